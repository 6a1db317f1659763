#include "common/descriptor/network_family.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/security/secret.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::size_t profile_sectors = 64;
constexpr double least_seen = 0.4;  // share of pixels; about what the narrowest lidar fills when it is tilted

/// The version, 1 to 65536, derived from the image: the same network with another image is another family.
int version_of(const NetworkImage& image) {
  const auto& s = image.spec;
  std::string text = std::to_string(s.rows) + " " + std::to_string(s.columns) + " " + std::to_string(s.top_deg) + " ";
  text.append(std::to_string(s.bottom_deg)).append(image.encoding == ImageEncoding::range_m ? " range" : " log");
  const std::string hash = sha256(text);
  return 1 + (static_cast<unsigned char>(hash[0]) << 8 | static_cast<unsigned char>(hash[1]));
}

void scale_to_one(std::vector<float>& q) {
  float squares = 0;
  for (const float v : q) squares += v * v;
  for (float& v : q) v /= std::sqrt(std::max(squares, 1e-12F));
}

}  // namespace

std::vector<float> azimuth_profile(const RangeImage& image) {
  std::vector<float> sum(profile_sectors, 0), count(profile_sectors, 0);
  float sum_all = 0, count_all = 0;
  for (std::size_t r = 0; r < image.spec.rows; ++r)
    for (std::size_t c = 0; c < image.spec.columns; ++c) {
      if (!(image.at(r, c) > 0)) continue;
      const std::size_t sector = c * profile_sectors / image.spec.columns;
      sum[sector] += std::log(image.at(r, c));
      count[sector] += 1;
      sum_all += std::log(image.at(r, c));
      count_all += 1;
    }
  for (std::size_t s = 0; s < profile_sectors; ++s)
    sum[s] = count[s] > 0 ? sum[s] / count[s] : sum_all / std::max(count_all, 1.0F);
  return sum;
}

Result<void> NetworkFamily::know_outputs(const std::string& name) {
  std::string there;
  for (std::size_t i = 0; i < network_.outputs().size(); ++i) {
    const auto& [output, size] = network_.outputs()[i];
    there.append(there.empty() ? "" : ", ").append(output).append(" of ").append(std::to_string(size));
    if (output == "q" && size >= 1 && size <= limits::descriptor_floats) q_ = i;
    if (output == "w" && size >= 8 && size <= limits::descriptor_floats) w_ = i;
    if (output == "junction" && size == 1) junction_ = i;
  }
  const std::size_t known = (q_ ? 1U : 0U) + (w_ ? 1U : 0U) + (junction_ ? 1U : 0U);
  if (q_ && known == network_.outputs().size()) return {};
  return failure(ErrorCode::bad_input, name + ": its outputs are " + there +
                                           "; they must be q (1 to 4096 values), and if it has them w (8 to 4096) and "
                                           "junction (1), by these names and no others");
}

Result<std::unique_ptr<NetworkFamily>> NetworkFamily::make(FamilyId id, Network network, const NetworkImage& image,
                                                           QLength q_length, const std::string& name) {
  if (network.input() != image.shape())
    return failure(ErrorCode::bad_input, name + ": it takes an image of " + to_string(network.input()) +
                                             " (channels x rows x columns), and is to be given one of " +
                                             to_string(image.shape()));
  auto family = std::unique_ptr<NetworkFamily>(new NetworkFamily(std::move(id), std::move(network), image, q_length));
  if (auto ok = family->know_outputs(name); !ok) return tl::unexpected(ok.error());
  return family;
}

std::string NetworkFamily::bounds() const {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%.1f to %.1f deg from the horizon", image_.spec.bottom_deg,
                image_.spec.top_deg);
  return text.data();
}

std::size_t NetworkFamily::w_size() const { return w_ ? network_.outputs()[*w_].size : profile_sectors; }

Result<Descriptor> NetworkFamily::extract(const Points& points_level) const {
  if (auto enough = enough_points(points_level); !enough) return tl::unexpected(enough.error());
  return describe(image_.draw(points_level));
}

Result<Descriptor> NetworkFamily::describe(const RangeImage& image) const {
  if (seen_share(image) == 0)
    return failure(ErrorCode::bad_input,
                   "no point of the scan lies within " + bounds() + ", where " + id_.name + " looks");
  auto values = network_.run(image_.encode(image));
  if (!values) return tl::unexpected(values.error());
  Descriptor d;
  d.q = std::move((*values)[*q_]);
  if (q_length_ == QLength::one) scale_to_one(d.q);
  d.w = w_ ? std::move((*values)[*w_]) : azimuth_profile(image);
  if (junction_) d.place_class = (*values)[*junction_][0] > 0 ? PlaceClass::junction : PlaceClass::tunnel;
  return d;
}

std::string NetworkFamily::unfamiliar(const Points& points_level) const {
  const double seen = seen_share(image_.draw(points_level));
  if (seen >= least_seen) return {};
  return "the scan fills " + std::to_string(std::lround(100 * seen)) + " % of the picture that " + id_.name +
         " looks at (" + bounds() +
         "): a lidar or a place unlike those it was trained on; places are told apart less surely";
}

Result<std::unique_ptr<DescriptorFamily>> make_onnx_family(const std::filesystem::path& file) {
  const std::string name = file.string(), beside = name + ".json";
  const auto onnx = Network::read(file);
  if (!onnx) return tl::unexpected(onnx.error());
  const auto json = Network::read(beside);
  if (!json)
    return failure(json.error().code, json.error().message + "; it says how the network's image is made: " +
                                          std::string(network_image_example));
  const auto image = parse_network_image(*json, beside);
  if (!image) return tl::unexpected(image.error());
  auto network = Network::from_bytes(*onnx, name);
  if (!network) return tl::unexpected(network.error());
  const std::string hash = to_hex(sha256(*onnx)).substr(0, 12);
  return NetworkFamily::make({"onnx-" + hash, version_of(*image)}, std::move(*network), *image,
                             NetworkFamily::QLength::as_it_is, name);
}

}  // namespace headframe
