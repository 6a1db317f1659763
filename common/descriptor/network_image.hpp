#pragma once
// How a scan becomes the image that a network was trained on.

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

/// The text of the file that lies beside a network, named as it with .json added: all of rows, columns, fov_up_deg,
/// fov_down_deg (from the horizon, down positive too) and encoding. bad_input says which key is missing, unknown or
/// wrong; name: what messages call the file.
Result<NetworkImage> parse_network_image(std::string_view json_text, const std::string& name);

/// What such a file may look like.
inline constexpr std::string_view network_image_example =
    R"({"rows": 16, "columns": 256, "fov_up_deg": 11.2, "fov_down_deg": 11.2, "encoding": "log_range_mask"})";

}  // namespace headframe
