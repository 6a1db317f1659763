// The weights are part of the program, taken in by the assembler: a robot needs no file beside it.
#include "common/descriptor/network_family.hpp"
#include "common/descriptor/open_sky.hpp"

asm(".pushsection .rodata\nheadframe_learned: .incbin \"" HEADFRAME_LEARNED_ONNX
    "\"\nheadframe_learned_end:\n.popsection");
extern "C" const char headframe_learned[], headframe_learned_end[];

namespace headframe {

namespace {

class Learned : public DescriptorFamily {
 public:
  explicit Learned(std::unique_ptr<NetworkFamily> network) : network_(std::move(network)) {}

  FamilyId id() const override { return network_->id(); }
  std::size_t q_size() const override { return network_->q_size() + open_sky_q_size; }
  std::size_t w_size() const override { return network_->w_size(); }
  std::string unfamiliar(const Points& points_level) const override { return network_->unfamiliar(points_level); }

  Result<Descriptor> extract(const Points& points_level) const override {
    if (auto enough = enough_points(points_level); !enough) return tl::unexpected(enough.error());
    const RangeImage image = network_->draw(points_level);
    auto descriptor = network_->describe(image);
    if (!descriptor) return descriptor;
    if (auto ok = add_open_sky(*descriptor, points_level, openness(image)); !ok) return tl::unexpected(ok.error());
    return descriptor;
  }

 private:
  std::unique_ptr<NetworkFamily> network_;
};

}  // namespace

Result<std::unique_ptr<DescriptorFamily>> make_learned() {
  const auto size = static_cast<std::size_t>(headframe_learned_end - headframe_learned);
  auto network = Network::from_bytes({headframe_learned, size}, "learned");
  if (!network) return tl::unexpected(network.error());
  auto family =
      NetworkFamily::make({"learned", 2}, std::move(*network), NetworkImage{}, NetworkFamily::QLength::one, "learned");
  if (!family) return tl::unexpected(family.error());
  return std::make_unique<Learned>(std::move(*family));
}

}  // namespace headframe
