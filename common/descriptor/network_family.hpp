#pragma once

#include <optional>

#include "common/descriptor/family.hpp"
#include "common/descriptor/network_image.hpp"

namespace headframe {

/// A family whose descriptors a network makes: q is its output `q`, w its output `w`, the class its output `junction`
/// (above 0: a junction). Without `w`, w is the image's azimuth profile: the mean logarithm of the range in 64 sectors.
class NetworkFamily : public DescriptorFamily {
 public:
  enum class QLength { as_it_is, one };  // one: q is scaled to length 1, which OpenCV's DNN module can not do itself

  /// bad_input when the network takes another image, has no `q`, or an output that is none of these or has a wrong
  /// size. name: of the network, for messages.
  static Result<std::unique_ptr<NetworkFamily>> make(FamilyId id, Network network, const NetworkImage& image,
                                                     QLength q_length, const std::string& name);

  FamilyId id() const override { return id_; }
  std::size_t q_size() const override { return network_.outputs()[*q_].size; }
  std::size_t w_size() const override;
  Result<Descriptor> extract(const Points& points_level) const override;
  std::string unfamiliar(const Points& points_level) const override;

  /// The steps of extract(), but for looking whether there are points enough.
  RangeImage draw(const Points& points_level) const { return image_.draw(points_level); }
  Result<Descriptor> describe(const RangeImage& image) const;

 private:
  NetworkFamily(FamilyId id, Network network, const NetworkImage& image, QLength q_length)
      : id_(std::move(id)), network_(std::move(network)), image_(image), q_length_(q_length) {}
  Result<void> know_outputs(const std::string& name);
  std::string bounds() const;  // of what it looks at

  FamilyId id_;
  Network network_;
  NetworkImage image_;
  QLength q_length_;
  std::optional<std::size_t> q_, w_, junction_;  // among the network's outputs
};

/// The network that is part of this program: q of 64, w of 64, with the class; q goes on with what counts under the
/// open sky (open_sky.hpp).
Result<std::unique_ptr<DescriptorFamily>> make_learned();

/// A network of the user's own; FILE.json says how its image is made (parse_network_image). The name is made of the
/// network's bytes and the version of its image, so that sessions meet only when both are the same.
Result<std::unique_ptr<DescriptorFamily>> make_onnx_family(const std::filesystem::path& file);

/// The mean logarithm of the range (metres) in each of 64 sectors; the mean of the others where nothing returns.
std::vector<float> azimuth_profile(const RangeImage& image);

}  // namespace headframe
