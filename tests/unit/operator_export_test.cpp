#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "server/cli/http_client.hpp"
#include "server/operator/las.hpp"
#include "tests/support/operator_server.hpp"

namespace headframe {
namespace {

struct Vertex {
  float x, y, z;
  std::uint32_t colour;  // 0x00RRGGBB
};

struct CloudFile {
  std::string header;
  std::size_t declared = 0;
  std::vector<Vertex> vertices;
};

/// Reads what map_export writes, by the header's own count; the body must end where the last point does.
CloudFile read_cloud(const std::string& file, const std::string& end_of_header, const std::string& count_key,
                     std::size_t stride) {
  CloudFile out;
  const std::size_t body = file.find(end_of_header) + end_of_header.size();
  out.header = file.substr(0, body);
  out.declared = std::stoul(out.header.substr(out.header.find(count_key) + count_key.size()));
  EXPECT_EQ(file.size() - body, out.declared * stride);
  for (std::size_t at = body; at + stride <= file.size(); at += stride) {
    Vertex v{};
    std::memcpy(&v, file.data() + at, stride);
    if (stride == 15) v.colour = (v.colour & 0xff) << 16 | (v.colour & 0xff00) | (v.colour >> 16 & 0xff);
    out.vertices.push_back(v);
  }
  return out;
}

CloudFile read_ply(const std::string& file) { return read_cloud(file, "end_header\n", "element vertex ", 15); }
CloudFile read_pcd(const std::string& file) { return read_cloud(file, "DATA binary\n", "\nPOINTS ", 16); }

class OperatorExportTest : public testing::Test {
 protected:
  std::string get(const std::string& query) {
    const auto response = client.get("/api/v1/export?" + query);
    EXPECT_TRUE(response) << response.error().message;
    EXPECT_EQ(response ? response->status : 0, 200) << response->body;
    return response ? response->body : "";
  }
  OperatorServer server;
  HttpClient client{*parse_http_endpoint(server.where())};
};

TEST_F(OperatorExportTest, PlyHasAllPointsOfTheComponentInItsFrame) {
  const CloudFile ply = read_ply(get("component=1"));
  EXPECT_EQ(ply.header.substr(0, 36), "ply\nformat binary_little_endian 1.0\n");
  EXPECT_NE(ply.header.find("comment robot beta colour 31 120 180\n"), std::string::npos);
  // 2 sessions x 2 keyframes with a cloud x 10 points; the NaN of each cloud and the keyframe without one are left out.
  ASSERT_EQ(ply.declared, 40U);
  ASSERT_EQ(ply.vertices.size(), 40U);
  // Session 2, keyframe 2 stands at x = 1 of its session, which T_1_2 turns by 90 deg and moves by (10, 20, 30).
  const Vertex& v = ply.vertices[30 + 0];
  EXPECT_NEAR(v.x, 10, 1e-5);
  EXPECT_NEAR(v.y, 21, 1e-5);
  EXPECT_NEAR(v.z, 32, 1e-5);
  EXPECT_EQ(v.colour, 31U << 16 | 120U << 8 | 180U);
  EXPECT_NE(ply.vertices[0].colour, v.colour) << "another robot";
}

TEST_F(OperatorExportTest, PcdHasTheSamePoints) {
  const CloudFile pcd = read_pcd(get("component=1&format=pcd"));
  const CloudFile ply = read_ply(get("component=1&format=ply"));
  ASSERT_EQ(pcd.declared, 40U);
  EXPECT_NE(pcd.header.find("\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 40\nHEIGHT 1\n"),
            std::string::npos);
  ASSERT_EQ(pcd.vertices.size(), ply.vertices.size());
  for (std::size_t i = 0; i < pcd.vertices.size(); ++i) {
    EXPECT_EQ(pcd.vertices[i].y, ply.vertices[i].y);
    EXPECT_EQ(pcd.vertices[i].colour, ply.vertices[i].colour);
  }
}

template <class T>
T value_at(const std::string& file, std::size_t offset) {
  T value{};
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

TEST_F(OperatorExportTest, LasHasTheSamePointsToAMillimetre) {
  const std::string las = get("component=1&format=las");
  const CloudFile ply = read_ply(get("component=1"));
  ASSERT_EQ(las.substr(0, 4), "LASF");
  EXPECT_EQ(las[24] * 10 + las[25], 12) << "version 1.2";
  EXPECT_EQ(value_at<std::uint16_t>(las, 94), 227) << "bytes of the header";
  EXPECT_EQ(value_at<std::uint32_t>(las, 96), 227U) << "where the points begin";
  EXPECT_EQ(las[104], 3) << "point format: with time and colour";
  EXPECT_EQ(value_at<std::uint16_t>(las, 4), 1U) << "source: the component";
  EXPECT_EQ(value_at<std::uint16_t>(las, 6), 0U) << "stamps count from a start of the robot's own";
  EXPECT_TRUE(value_at<std::uint16_t>(las, 90) >= 1 && value_at<std::uint16_t>(las, 90) <= 366) << "day of making";
  EXPECT_GE(value_at<std::uint16_t>(las, 92), 2024U);
  ASSERT_EQ(value_at<std::uint32_t>(las, 107), ply.declared);
  ASSERT_EQ(las.size(), 227 + 34 * ply.declared);
  double most_x = -1e9, least_x = 1e9;
  for (std::size_t i = 0; i < ply.declared; ++i) {
    const std::size_t at = 227 + 34 * i;
    const double x = value_at<std::int32_t>(las, at) * value_at<double>(las, 131);
    EXPECT_NEAR(x, ply.vertices[i].x, 6e-4);
    EXPECT_NEAR(value_at<std::int32_t>(las, at + 8) * 0.001, ply.vertices[i].z, 6e-4);
    EXPECT_EQ(value_at<std::uint16_t>(las, at + 28) / 257U, ply.vertices[i].colour >> 16) << "red";
    most_x = std::max(most_x, x);
    least_x = std::min(least_x, x);
  }
  EXPECT_NEAR(value_at<double>(las, 179), most_x, 1e-9) << "the box holds the points as they are written";
  EXPECT_NEAR(value_at<double>(las, 187), least_x, 1e-9);
  std::set<std::uint16_t> sources;
  for (std::size_t i = 0; i < ply.declared; ++i) sources.insert(value_at<std::uint16_t>(las, 227 + 34 * i + 18));
  EXPECT_EQ(sources, (std::set<std::uint16_t>{1, 2})) << "a session each";
}

/// The fifth to ninth point of each keyframe of session 2 are its second sweep's, which has intensities from 100 on.
TEST_F(OperatorExportTest, IntensitiesGoWithTheirPointsInEveryFormat) {
  ASSERT_EQ(get("component=1").find("intensity"), std::string::npos) << "no robot gave any";
  server.station.painted = 2;
  const auto wanted = [](std::size_t i) { return i < 20 || i % 10 < 5 ? 0U : 100U + 10U * (i % 10 - 5); };
  const std::string ply = get("component=1"), pcd = get("component=1&format=pcd"), las = get("component=1&format=las");
  EXPECT_NE(ply.find("property uchar blue\nproperty uchar intensity\nend_header\n"), std::string::npos);
  EXPECT_NE(pcd.find("\nFIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 1 1\nWIDTH 40\n"),
            std::string::npos);
  const std::size_t ply_body = ply.find("end_header\n") + 11, pcd_body = pcd.find("DATA binary\n") + 12;
  ASSERT_EQ(ply.size(), ply_body + std::size_t{40} * 16);
  ASSERT_EQ(pcd.size(), pcd_body + std::size_t{40} * 20);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(value_at<std::uint8_t>(ply, ply_body + 16 * i + 15), wanted(i)) << i;
    EXPECT_EQ(value_at<float>(pcd, pcd_body + 20 * i + 16), static_cast<float>(wanted(i))) << i;
    EXPECT_EQ(value_at<std::uint16_t>(las, 227 + 34 * i + 12), wanted(i) * 257) << i;
  }
}

TEST_F(OperatorExportTest, ThinnedPointsHaveTheMeanIntensity) {
  server.station.painted = 2;
  const std::string las = get("component=1&format=las&voxel=100");
  ASSERT_EQ(las.size(), 227U + 34U * 4U) << "one point a keyframe";
  EXPECT_EQ(value_at<std::uint16_t>(las, 227 + 12), 0);
  EXPECT_EQ(value_at<std::uint16_t>(las, 227 + 34 * 3 + 12), 60 * 257) << "five of 0, and 100 to 140";
}

TEST(Las, TimeIsThatOfTheSatellites) {
  EXPECT_EQ(adjusted_gps_s(315964800 + 1e9 - 15), 0) << "a billion seconds of GPS, when UTC was 15 s behind";
  EXPECT_EQ(adjusted_gps_s(1483228799), 1483228799 - 315964800 + 17 - 1e9) << "before the leap second";
  EXPECT_EQ(adjusted_gps_s(1483228800), 1483228800 - 315964800 + 18 - 1e9);
}

/// An anchor that counts from far away: points 1 m apart stay 1 m apart, whatever the format.
TEST_F(OperatorExportTest, AComponentFarFromItsOriginKeepsItsMillimetres) {
  const CloudFile near = read_ply(get("component=1"));
  const Eigen::Vector3d far(500123.4, 5000321.6, 12);
  for (Placement& placement : server.station.view.atlas.components[0].placements)
    placement.T_component_session = Eigen::Translation3d(far) * placement.T_component_session;
  const auto expect_near = [&](std::size_t i, const Eigen::Vector3d& p) {
    const Vertex& v = near.vertices[i];
    EXPECT_LT((Eigen::Vector3d(v.x, v.y, v.z) + far - p).norm(), 2e-3) << i << ": " << p.transpose();
  };
  const std::string ply = get("component=1"), pcd = get("component=1&format=pcd");
  const std::size_t body = ply.find("end_header\n") + 11;
  ASSERT_EQ(ply.size() - body, near.vertices.size() * 27);
  for (std::size_t i = 0; i < near.vertices.size(); ++i) {
    Eigen::Vector3d p;
    std::memcpy(p.data(), ply.data() + body + 27 * i, sizeof p);
    expect_near(i, p);
  }
  ASSERT_NE(pcd.find("# offset 500123 5000322 12: add it to every point\n"), std::string::npos) << pcd.substr(0, 200);
  const auto vertices = read_pcd(pcd).vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    expect_near(i, Eigen::Vector3d(vertices[i].x, vertices[i].y, vertices[i].z) + Eigen::Vector3d(500123, 5000322, 12));
}

/// The grid is a million metres away: whatever the format, its points are the component's laid into it, to a
/// millimetre.
TEST_F(OperatorExportTest, TheGridIsKeptToAMillimetreInEveryFormat) {
  const Pose T_grid_2 = pose_from_yaw(0.7, {1431250.256, 6212400.125, -312.5});
  server.station.surveyed = {{2, T_grid_2, {}}};
  const Pose T_grid_component =
      T_grid_2 * server.station.view.atlas.components[0].placements[1].T_component_session.inverse();
  const CloudFile own = read_ply(get("component=1"));
  std::vector<Eigen::Vector3d> wanted;
  for (const Vertex& v : own.vertices) wanted.push_back(T_grid_component * Eigen::Vector3d(v.x, v.y, v.z));
  const auto expect_points = [&](const char* format, const auto& point) {
    for (std::size_t i = 0; i < wanted.size(); ++i)
      ASSERT_LT((point(i) - wanted[i]).norm(), 1.5e-3) << format << " point " << i;
  };
  const std::string ply = get("component=1&frame=grid");
  const std::size_t body = ply.find("end_header\n") + 11;
  ASSERT_NE(ply.find("property double x\nproperty double y"), std::string::npos);
  ASSERT_EQ(ply.size(), body + 27 * wanted.size());
  expect_points("ply", [&](std::size_t i) {
    const std::size_t at = body + 27 * i;
    return Eigen::Vector3d(value_at<double>(ply, at), value_at<double>(ply, at + 8), value_at<double>(ply, at + 16));
  });
  const std::string las = get("component=1&frame=grid&format=las");
  ASSERT_EQ(las.size(), 227 + 34 * wanted.size());
  const Eigen::Vector3d offset(value_at<double>(las, 155), value_at<double>(las, 163), value_at<double>(las, 171));
  EXPECT_GT(offset.y(), 6e6);
  expect_points("las", [&](std::size_t i) -> Eigen::Vector3d {
    const std::size_t at = 227 + 34 * i;
    return offset + 0.001 * Eigen::Vector3d(value_at<std::int32_t>(las, at), value_at<std::int32_t>(las, at + 4),
                                            value_at<std::int32_t>(las, at + 8));
  });
  EXPECT_NEAR(value_at<double>(las, 195),
              std::max_element(wanted.begin(), wanted.end(), [](auto& p, auto& q) { return p.y() < q.y(); })->y(), 1e-3)
      << "greatest y of the header";
  const std::string pcd = get("component=1&frame=grid&format=pcd");
  Eigen::Vector3d pcd_offset;
  std::istringstream(pcd.substr(pcd.find("# offset ") + 9)) >> pcd_offset.x() >> pcd_offset.y() >> pcd_offset.z();
  const std::size_t data = pcd.find("DATA binary\n") + 12;
  expect_points("pcd", [&](std::size_t i) -> Eigen::Vector3d {
    const std::size_t at = data + 16 * i;
    return pcd_offset +
           Eigen::Vector3d(value_at<float>(pcd, at), value_at<float>(pcd, at + 4), value_at<float>(pcd, at + 8));
  });
}

TEST_F(OperatorExportTest, TheGridNeedsASurvey) {
  EXPECT_EQ(client.get("/api/v1/export?component=1&frame=grid")->status, 404);
  EXPECT_EQ(client.get("/api/v1/export?component=1&frame=mars")->status, 400);
  EXPECT_EQ(client.get("/api/v1/trajectory?robot=beta&session=run%2F1&frame=grid")->status, 404);
  server.station.surveyed = {{1, pose_from_yaw(0, {1000000, 2000000, 3}), {}}};
  const std::string tum = client.get("/api/v1/trajectory?robot=beta&session=run%2F1&frame=grid")->body;
  EXPECT_NE(tum.find("# headframe: the mine's grid"), std::string::npos) << tum;
  EXPECT_NE(tum.find("200.000000 1000010.000000 2000020.000000 33.000000 "), std::string::npos) << tum;
}

TEST_F(OperatorExportTest, VoxelThinsWithinAKeyframe) {
  EXPECT_EQ(read_ply(get("component=3&voxel=0.99")).declared, 20U) << "points are 1 m apart";
  EXPECT_EQ(read_ply(get("component=3&voxel=5")).declared, 4U) << "10 m in cubes of 5 m, two keyframes";
  EXPECT_EQ(read_ply(get("component=3&voxel=0")).declared, 20U);
}

TEST_F(OperatorExportTest, AComponentWithoutCloudsIsAnEmptyCloud) {
  server.station.points = 0;
  EXPECT_EQ(read_ply(get("component=1")).declared, 0U);
  EXPECT_EQ(read_pcd(get("component=1&format=pcd")).declared, 0U);
}

TEST_F(OperatorExportTest, ManyPointsComeInPieces) {
  server.station.points = 200000;
  std::size_t bytes = 0, pieces = 0;
  const auto response = client.get("/api/v1/export?component=3&voxel=0", [&](std::string_view piece) -> Result<void> {
    bytes += piece.size();
    ++pieces;
    return {};
  });
  ASSERT_TRUE(response);
  EXPECT_GT(bytes, 2U * 200000 * 15);
  EXPECT_GT(pieces, 10U);
  EXPECT_EQ(server.station.clouds_read, 3 + 2) << "counted: three keyframes; written: the two with a cloud";
}

TEST_F(OperatorExportTest, AFaultBeforeTheFirstPointIsAnError) {
  server.station.cloud_that_breaks = 2;  // while counting
  const auto response = client.get("/api/v1/export?component=1");
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 500);
  EXPECT_NE(response->body.find("a damaged cloud"), std::string::npos);
}

TEST_F(OperatorExportTest, AFaultInTheMiddleBreaksTheAnswerOff) {
  server.station.cloud_that_breaks = 5;  // component 3: 1 to 3 are counted, 4 and 5 written
  const auto response = client.get("/api/v1/export?component=3");
  ASSERT_FALSE(response) << "half a map must not look whole";
  EXPECT_EQ(response.error().code, ErrorCode::unavailable);
  EXPECT_NE(response.error().message.find("broke off"), std::string::npos);
}

TEST_F(OperatorExportTest, ASinkThatRefusesEndsTheRequest) {
  const auto response = client.get("/api/v1/export?component=1", [](std::string_view) -> Result<void> {
    return failure(ErrorCode::unavailable, "disk full");
  });
  ASSERT_FALSE(response);
  EXPECT_EQ(response.error().message, "disk full");
}

}  // namespace
}  // namespace headframe
