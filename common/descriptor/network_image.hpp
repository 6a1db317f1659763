#pragma once
// Converts a scan to the image that a network was trained on.

#include <string>
#include <string_view>
#include <vector>

#include "common/descriptor/network.hpp"
#include "common/descriptor/range_image.hpp"

namespace headframe {

enum class ImageEncoding {
  log_range_mask,  // small holes filled; two channels, see log_range_and_mask()
  range_m,         // one channel: metres, 0 where there is no return
};

struct NetworkImage {
  RangeImageSpec spec;
  ImageEncoding encoding = ImageEncoding::log_range_mask;

  Network::Shape shape() const;
  RangeImage draw(const Points& points_level) const;
  std::vector<float> encode(const RangeImage& image) const;
};

/// Parses the file beside a network, which has the network's name with .json added: rows, columns, fov_up_deg,
/// fov_down_deg (from the horizon, down positive too) and encoding, all required. bad_input names the key that is
/// missing, unknown or wrong; name: of the file, for messages.
Result<NetworkImage> parse_network_image(std::string_view json_text, const std::string& name);

/// An example of such a file.
inline constexpr std::string_view network_image_example =
    R"({"rows": 16, "columns": 256, "fov_up_deg": 11.2, "fov_down_deg": 11.2, "encoding": "log_range_mask"})";

}  // namespace headframe
