#include "tests/mine/ray_caster.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace headframe::mine {

struct RayCaster::Scene {
  RTCDevice device = rtcNewDevice("threads=2");
  RTCScene scene = rtcNewScene(device);

  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const Mesh& mesh) : scene_(std::make_unique<Scene>()) {
  if (mesh.triangles.empty()) {
    rtcCommitScene(scene_->scene);
    return;
  }
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(mesh.vertices[0]), mesh.vertices.size());
  std::memcpy(vertices, mesh.vertices.front().data(), mesh.vertices.size() * sizeof(mesh.vertices[0]));
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            sizeof(mesh.triangles[0]), mesh.triangles.size());
  std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(scene_->scene);
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<Hit> RayCaster::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                   float max_range_m) const {
  RTCRayHit query{};
  query.ray.org_x = origin.x(), query.ray.org_y = origin.y(), query.ray.org_z = origin.z();
  query.ray.dir_x = direction.x(), query.ray.dir_y = direction.y(), query.ray.dir_z = direction.z();
  query.ray.tfar = max_range_m;
  query.ray.mask = 0xffffffffU;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Eigen::Vector3f normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  return Hit{query.ray.tfar, std::abs(normal.dot(direction)) / std::max(normal.norm(), 1e-12F)};
}

}  // namespace headframe::mine
