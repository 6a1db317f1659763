#pragma once

#include <optional>

#include "common/descriptor/family.hpp"
#include "common/descriptor/network_image.hpp"

namespace headframe {

/// A family whose descriptors come from a network: q from its output `q`, w from its output `w`, the class from its
/// output `junction` (above 0: a junction). Without an output `w`, w is the image's azimuth profile: the mean logarithm
/// of the range in 64 sectors.
class NetworkFamily : public DescriptorFamily {
 public:
  enum class QLength { as_it_is, one };  // one: q is scaled to length 1, which OpenCV's DNN module cannot do

  /// bad_input: the network takes another image, has no `q`, or has an output with another name or a wrong size. name:
  /// of the network, for messages.
  static Result<std::unique_ptr<NetworkFamily>> make(FamilyId id, Network network, const NetworkImage& image,
                                                     QLength q_length, const std::string& name);

  FamilyId id() const override { return id_; }
  std::size_t q_size() const override { return network_.outputs()[*q_].size; }
  std::size_t w_size() const override;
  Result<Descriptor> extract(const Points& points_level) const override;
  std::string unfamiliar(const Points& points_level) const override;

  /// The steps of extract(), without checking whether there are enough points.
  RangeImage draw(const Points& points_level) const { return image_.draw(points_level); }
  Result<Descriptor> describe(const RangeImage& image) const;

 private:
  NetworkFamily(FamilyId id, Network network, const NetworkImage& image, QLength q_length)
      : id_(std::move(id)), network_(std::move(network)), image_(image), q_length_(q_length) {}
  Result<void> know_outputs(const std::string& name);
  std::string bounds() const;  // of the image, as text

  FamilyId id_;
  Network network_;
  NetworkImage image_;
  QLength q_length_;
  std::optional<std::size_t> q_, w_, junction_;  // among the network's outputs
};

/// The built-in network: q of 64, w of 64, and the class; q is extended by what matters under the open sky
/// (open_sky.hpp).
Result<std::unique_ptr<DescriptorFamily>> make_learned();

/// A network of the user's own; FILE.json says how its image is made (parse_network_image). The family's name is
/// derived from the network's bytes and its version from the image, so that only sessions with the same network and
/// image are compared.
Result<std::unique_ptr<DescriptorFamily>> make_onnx_family(const std::filesystem::path& file);

/// The mean logarithm of the range (metres) in each of 64 sectors; sectors without returns get the mean of the others.
std::vector<float> azimuth_profile(const RangeImage& image);

}  // namespace headframe
