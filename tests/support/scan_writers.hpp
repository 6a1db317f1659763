#pragma once
// Scan files of every format the reader knows, written the plainest way, to read back in tests.

#include <cstdint>
#include <cstring>
#include <string>

#include "common/cloud/point_cloud.hpp"

namespace headframe::testing {

template <class T>
void append_raw(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof bytes);
}

/// Valid LZF that uses copies where the last bytes repeat, so that unpacking meets both kinds of token.
inline std::string lzf_pack(const std::string& bytes) {
  std::string out;
  std::size_t at = 0;
  while (at < bytes.size()) {
    std::size_t length = 0;
    while (at > 0 && at + length < bytes.size() && length < 264 && bytes[at + length] == bytes[at - 1]) ++length;
    if (length < 3) {
      out += '\0';
      out += bytes[at++];
      continue;
    }
    at += length;
    length -= 2;
    out += static_cast<char>((length < 7 ? length : 7) << 5);
    if (length >= 7) out += static_cast<char>(length - 7);
    out += '\0';  // distance 1
  }
  return out;
}

inline std::string numbers(const Points& points, const char* between) {
  std::string out;
  for (const auto& p : points)
    out += std::to_string(p.z()) + between + "7" + between + std::to_string(p.x()) + between + std::to_string(p.y()) +
           "\n";
  return out;
}

/// Fields z (double), ring (16 bit), x, y (float): an order and sizes that no reader may take for granted.
inline std::string pcd(const Points& points, const std::string& data) {
  const std::string n = std::to_string(points.size());
  std::string out = "# .PCD v0.7\nVERSION 0.7\nFIELDS z ring x y\nSIZE 8 2 4 4\nTYPE F U F F\nCOUNT 1 1 1 1\nWIDTH " +
                    n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA " + data + "\n";
  if (data == "ascii") return out + numbers(points, " ");
  if (data == "binary") {
    for (const auto& p : points) {
      append_raw<double>(out, p.z());
      append_raw<std::uint16_t>(out, 7);
      append_raw<float>(out, p.x());
      append_raw<float>(out, p.y());
    }
    return out;
  }
  std::string columns;
  for (const auto& p : points) append_raw<double>(columns, p.z());
  for (std::size_t i = 0; i < points.size(); ++i) append_raw<std::uint16_t>(columns, 7);
  for (const auto& p : points) append_raw<float>(columns, p.x());
  for (const auto& p : points) append_raw<float>(columns, p.y());
  const std::string packed = lzf_pack(columns);
  append_raw(out, static_cast<std::uint32_t>(packed.size()));
  append_raw(out, static_cast<std::uint32_t>(columns.size()));
  return out + packed;
}

/// The same fields as PLY, with faces after the vertices.
inline std::string ply(const Points& points, const std::string& format) {
  std::string out = "ply\nformat " + format + " 1.0\ncomment drawn\nelement vertex " + std::to_string(points.size()) +
                    "\nproperty double z\nproperty ushort ring\nproperty float x\nproperty float32 y\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n";
  if (format == "ascii") return out + numbers(points, " ") + "4 0 0 0 0\n";
  for (const auto& p : points) {
    append_raw<double>(out, p.z());
    append_raw<std::uint16_t>(out, 7);
    append_raw<float>(out, p.x());
    append_raw<float>(out, p.y());
  }
  return out;
}

inline std::string kitti(const Points& points) {
  std::string out;
  for (const auto& p : points)
    for (const float v : {p.x(), p.y(), p.z(), 0.5F}) append_raw(out, v);
  return out;
}

}  // namespace headframe::testing
