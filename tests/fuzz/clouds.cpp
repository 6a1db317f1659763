// The cloud decoder: as bytes from the wire, and behind the compression, where a mutation gets further.
#include <zstd.h>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/limits.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  auto bytes = fuzz::text(data, size);
  std::string encoded;
  if (fuzz::take_byte(bytes) % 4 == 0) {
    encoded = bytes;
  } else {
    encoded.resize(ZSTD_compressBound(bytes.size()));
    encoded.resize(ZSTD_compress(encoded.data(), encoded.size(), bytes.data(), bytes.size(), -5));
  }
  const auto cloud = decode_cloud(encoded);
  if (!cloud) return 0;
  const std::size_t points = point_count(*cloud);
  fuzz::require(points <= limits::cloud_points && cloud->sweeps.size() <= limits::cloud_sweeps);
  for (const Sweep& sweep : cloud->sweeps)
    for (const auto& point : sweep.points) fuzz::require(point.allFinite());
  for (const Sweep& sweep : cloud->sweeps)
    fuzz::require(sweep.intensity.empty() || sweep.intensity.size() == sweep.points.size());
  const auto plain = without_intensity(encoded);
  fuzz::require(plain && point_count(decode_cloud(*plain).value()) == points);
  if (const auto again = encode_cloud(*cloud, 1.0F); again) {
    const auto back = decode_cloud(*again);
    fuzz::require(back.has_value() && point_count(*back) == points);
  }
  return 0;
}
