#include "common/dataset/scan_formats.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/dataset/lzf.hpp"
#include "tests/support/scan_writers.hpp"

namespace headframe {
namespace {

using dataset::parse_kitti;
using dataset::parse_pcd;
using dataset::parse_ply;
using namespace testing;  // NOLINT: the writers

const Points some_points{{1.5F, -2.25F, 3}, {0, 0, 0}, {0, 0, 0}, {-100.125F, 0.0625F, 7}, {4, 5, 6}};

struct Format {
  const char* name;
  Result<dataset::ScanTable> (*parse)(std::string_view);
  std::string bytes;
  bool text;
};

std::vector<Format> formats(const Points& points) {
  return {{"kitti", parse_kitti, kitti(points), false},
          {"pcd ascii", parse_pcd, pcd(points, "ascii"), true},
          {"pcd binary", parse_pcd, pcd(points, "binary"), false},
          {"pcd compressed", parse_pcd, pcd(points, "binary_compressed"), false},
          {"ply ascii", parse_ply, ply(points, "ascii"), true},
          {"ply binary", parse_ply, ply(points, "binary_little_endian"), false}};
}

std::string error_of(const Result<dataset::ScanTable>& result) { return result ? "no error" : result.error().message; }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ScanFormats, EveryFormatGivesThePointsBack) {
  for (const auto& format : formats(some_points)) {
    const auto read = format.parse(format.bytes);
    ASSERT_TRUE(read) << format.name << ": " << read.error().message;
    EXPECT_EQ(read->points, some_points) << format.name;
  }
}

TEST(ScanFormats, NoPointsAreAScanToo) {
  for (const auto& format : formats({})) {
    const auto read = format.parse(format.bytes);
    ASSERT_TRUE(read) << format.name << ": " << read.error().message;
    EXPECT_TRUE(read->points.empty()) << format.name;
  }
}

// A binary file that is cut anywhere is an error, never fewer points. A text file may lose its last line end, and
// digits of its last value; every cut before that is an error.
TEST(ScanFormats, CutAnywhereIsAnError) {
  for (const auto& format : formats(some_points)) {
    const std::size_t whole = format.text ? format.bytes.rfind("5.000000") : format.bytes.size();
    ASSERT_GT(whole, 0U);
    for (std::size_t cut = 0; cut < whole; ++cut) {
      if (std::string_view(format.name) == "kitti" && cut % 16 == 0) continue;  // such a file tells nothing of its end
      const auto read = format.parse(std::string_view(format.bytes).substr(0, cut));
      ASSERT_FALSE(read) << format.name << " cut at " << cut;
      EXPECT_EQ(read.error().code, ErrorCode::bad_input);
      EXPECT_FALSE(read.error().message.empty());
    }
  }
}

TEST(ScanFormats, DamagedBytesNeverDoMoreThanFail) {
  std::mt19937 rng(1);
  for (const auto& format : formats(some_points))
    for (int i = 0; i < 20000; ++i) {
      std::string bytes = format.bytes;
      for (unsigned flips = 0; flips <= rng() % 3; ++flips) bytes[rng() % bytes.size()] = static_cast<char>(rng());
      const auto read = format.parse(bytes);
      if (read) {
        EXPECT_LE(read->points.size(), 100 * bytes.size()) << format.name;
      }
    }
}

TEST(ScanFormats, ACountThatLiesIsFoundBeforeMemoryIsTaken) {
  for (const std::string lie : {"6", "99999999", "18446744073709551615", "-1", "5x"}) {
    for (const std::string data : {"ascii", "binary", "binary_compressed"}) {
      const std::string at_odds = replaced(pcd(some_points, data), "WIDTH 5", "WIDTH " + lie);
      EXPECT_FALSE(parse_pcd(at_odds)) << "WIDTH against POINTS";
      const std::string lying = replaced(at_odds, "POINTS 5", "POINTS " + lie);
      EXPECT_FALSE(parse_pcd(lying)) << data << " " << lie;
    }
    for (const std::string format : {"ascii", "binary_little_endian"}) {
      const std::string bytes = replaced(ply(some_points, format), "vertex 5", "vertex " + lie);
      EXPECT_FALSE(parse_ply(bytes)) << format << " " << lie;
    }
  }
  // Products of counts and sizes that wrap around 64 bits.
  std::string wraps = replaced(pcd(some_points, "binary"), "COUNT 1 1 1 1", "COUNT 1 4294967295 1 1");
  EXPECT_FALSE(parse_pcd(wraps));
  wraps = replaced(pcd(some_points, "binary"), "SIZE 8 2 4 4", "SIZE 8 65536 4 4");
  EXPECT_NE(error_of(parse_pcd(wraps)).find("bytes a point"), std::string::npos) << error_of(parse_pcd(wraps));
}

TEST(ScanFormats, ErrorsSayWhere) {
  const auto expect = [](const Result<dataset::ScanTable>& result, const std::string& words) {
    EXPECT_NE(error_of(result).find(words), std::string::npos) << error_of(result) << "\n  lacks: " << words;
  };
  expect(parse_kitti(std::string(40, 'x')), "40 bytes are no multiple of 16");
  expect(parse_kitti(std::string(40, 'x')), "byte 32");
  expect(parse_pcd(replaced(pcd(some_points, "ascii"), "1.500000", "1.5oo")), "line 12: '1.5oo' is no number");
  expect(parse_pcd(replaced(pcd(some_points, "ascii"), "SIZE 8 2 4 4", "SIZE 8 2 4")), "line 4");
  expect(parse_pcd(replaced(pcd(some_points, "ascii"), "z ring", "w ring")), "no field 'z'");
  expect(parse_pcd(replaced(pcd(some_points, "binary"), "SIZE 8 2 4", "SIZE 3 2 4")), "field 'z'");
  expect(parse_pcd(replaced(pcd(some_points, "binary"), "DATA binary", "DATA zip")), "'zip'");
  expect(parse_pcd("GET / HTTP/1.1\r\n"), "line 1");
  expect(parse_ply("\x7f"
                   "ELF"),
         "line 1");
  expect(parse_ply(replaced(ply(some_points, "ascii"), "format ascii", "format binary_big_endian")), "line 2");
  expect(parse_ply(replaced(ply(some_points, "ascii"), "property float x", "property list uchar int x")), "line 7");
  expect(parse_ply(replaced(ply(some_points, "ascii"), "element vertex", "element face")), "line 4");
  expect(parse_ply(replaced(ply(some_points, "ascii"), "float32 y", "float32 v")), "'y'");
}

TEST(ScanFormats, IntegersOfEverySizeAreRead) {
  std::string bytes = "FIELDS x y z\nSIZE 1 2 8\nTYPE I U I\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nDATA binary\n";
  append_raw<std::int8_t>(bytes, -5);
  append_raw<std::uint16_t>(bytes, 65535);
  append_raw<std::int64_t>(bytes, -1000);
  const auto read = parse_pcd(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->points, (Points{{-5, 65535, -1000}}));
}

TEST(ScanFormats, LineEndsOfOtherSystemsAreRead) {
  std::string dos;
  for (const char c : pcd(some_points, "ascii")) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const auto read = parse_pcd(dos);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->points, some_points);
}

TEST(ScanFormats, IntensitiesAreReadByTheirNames) {
  EXPECT_EQ(parse_kitti(kitti(some_points))->intensity, std::vector<float>(5, 0.5F));
  const std::vector<float> sevens(5, 7);
  for (const std::string name : {"intensity", "Intensity", "scalar_Intensity", "reflectivity", "REFLECTANCE"}) {
    for (const std::string data : {"ascii", "binary", "binary_compressed"}) {
      const auto read = parse_pcd(replaced(pcd(some_points, data), "ring", name));
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->intensity, sevens) << name << " " << data;
      EXPECT_EQ(read->points, some_points);
    }
    for (const std::string format : {"ascii", "binary_little_endian"})
      EXPECT_EQ(parse_ply(replaced(ply(some_points, format), "ring", name))->intensity, sevens) << name << format;
  }
  for (const std::string name : {"ring", "intensities", "scalar_", "scalar_ring"})
    EXPECT_TRUE(parse_pcd(replaced(pcd(some_points, "ascii"), "ring", name))->intensity.empty()) << name;
  const std::string both =
      "FIELDS reflectivity x y z intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 1 1\nWIDTH 1\nHEIGHT 1\n"
      "DATA ascii\n1 2 3 4 5\n";
  EXPECT_EQ(parse_pcd(both)->intensity, std::vector<float>{5}) << "the first of the names";
  std::string wide = replaced(pcd(some_points, "binary"), "ring", "intensity");
  wide = replaced(replaced(wide, "SIZE 8 2 4", "SIZE 8 1 4"), "COUNT 1 1", "COUNT 1 2");
  EXPECT_TRUE(parse_pcd(wide)->intensity.empty()) << "two numbers are no intensity";
  EXPECT_EQ(parse_pcd(wide)->points, some_points);
}

TEST(Lzf, UnpacksLiteralsAndCopiesThatOverlap) {
  // "abc" as it is, then 9 bytes from 3 back (length 7 + 0 + 2), then 3 bytes from 12 back.
  const std::string packed(
      "\x02"
      "abc"
      "\xe0\x00\x02"
      "\x20\x0b",
      9);
  EXPECT_EQ(dataset::lzf_unpack(packed, 15), "abcabcabcabcabc");
  EXPECT_FALSE(dataset::lzf_unpack(packed, 14));
  EXPECT_FALSE(dataset::lzf_unpack(packed, 16));
  for (std::size_t cut = 0; cut < packed.size(); ++cut) EXPECT_FALSE(dataset::lzf_unpack(packed.substr(0, cut), 15));
  EXPECT_FALSE(dataset::lzf_unpack(std::string("\x02"
                                               "abc"
                                               "\x20\x03",
                                               6),
                                   6))
      << "reaches back before the start";
  EXPECT_TRUE(dataset::lzf_unpack(std::string("\x02"
                                              "abc"
                                              "\x20\x02",
                                              6),
                                  6));
}

TEST(Lzf, GrowsNoMoreThanPromised) {
  const std::string zeros(1 << 20, '\0');
  const std::string packed = lzf_pack(zeros);
  EXPECT_EQ(dataset::lzf_unpack(packed, zeros.size()), zeros);
  EXPECT_LE(zeros.size(), packed.size() * dataset::lzf_most_growth);
  EXPECT_GT(zeros.size(), packed.size() * (dataset::lzf_most_growth - 1)) << "this is the worst case";
}

}  // namespace
}  // namespace headframe
