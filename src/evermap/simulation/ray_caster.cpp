// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <embree3/rtcore.h>

#include <evermap/simulation/ray_caster.hpp>

namespace evermap {
namespace {

using Device = std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)>;
using TriangleTree = std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)>;

Eigen::Vector3d middle(const Scene& scene) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& vertex : scene.vertices) bounds.extend(vertex);
  return bounds.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(bounds.center());
}

}  // namespace

class RayCaster::Tree {
 public:
  explicit Tree(const Scene& scene);

  std::optional<Hit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double limit) const;

 private:
  struct Plane {
    Eigen::Vector3d normal;
    double offset;  ///< normal . p of the points p of the plane
  };

  void build(const Scene& scene);

  Eigen::Vector3d middle_;     ///< [m] map frame, the origin of the coordinates below
  std::vector<Plane> planes_;  ///< by triangle
  std::vector<int> object_;    ///< by triangle
  Device device_;
  TriangleTree tree_;
};

// One instruction set on every machine, so that the same scene gives the same hits on every machine.
RayCaster::Tree::Tree(const Scene& scene)
    : middle_(middle(scene)),
      object_(scene.object),
      device_(rtcNewDevice("isa=sse2,threads=1"), &rtcReleaseDevice),
      tree_(nullptr, &rtcReleaseScene) {
  if (!device_) throw std::runtime_error("the ray caster (Embree) cannot be started");
  planes_.reserve(scene.triangles.size());
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    const Triangle3 triangle = scene.triangle(i);
    const Eigen::Vector3d normal = triangle.scaled_normal().normalized();
    planes_.push_back({normal, normal.dot(triangle.a - middle_)});
  }
  tree_.reset(rtcNewScene(device_.get()));
  build(scene);
  if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) {
    throw std::runtime_error("the ray caster (Embree) cannot take the scene");
  }
}

void RayCaster::Tree::build(const Scene& scene) {
  rtcSetSceneFlags(tree_.get(), RTC_SCENE_FLAG_ROBUST);
  if (!scene.triangles.empty()) {
    const RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), scene.vertices.size()));
    auto* triangle = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), scene.triangles.size()));
    if (vertex == nullptr || triangle == nullptr) {
      rtcReleaseGeometry(mesh);
      throw std::runtime_error("the ray caster (Embree) has no memory for the scene");
    }
    for (const Eigen::Vector3d& p_map : scene.vertices) {
      vertex = std::copy_n(Eigen::Vector3f((p_map - middle_).cast<float>()).data(), 3, vertex);
    }
    for (const auto& corners : scene.triangles) triangle = std::copy_n(corners.data(), 3, triangle);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(tree_.get(), mesh);
    rtcReleaseGeometry(mesh);
  }
  rtcCommitScene(tree_.get());
}

std::optional<RayCaster::Hit> RayCaster::Tree::first_hit(const Eigen::Vector3d& origin,
                                                         const Eigen::Vector3d& direction,
                                                         double limit) const {
  const Eigen::Vector3d local = origin - middle_;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(local.x());
  query.ray.org_y = static_cast<float>(local.y());
  query.ray.org_z = static_cast<float>(local.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tfar = static_cast<float>(limit);
  query.ray.mask = 0xFFFFFFFFU;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(tree_.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  const Plane& plane = planes_[query.hit.primID];
  const double single = query.ray.tfar;
  const double slant = plane.normal.dot(direction);
  const double exact = (plane.offset - plane.normal.dot(local)) / slant;
  // A ray within the plane has no crossing with it; there the single precision must do.
  const bool usable = std::abs(exact - single) < 1e-3 * (1 + single);
  return Hit{usable ? exact : single, std::abs(slant), object_[query.hit.primID]};
}

RayCaster::RayCaster(const Scene& scene) : tree_(std::make_unique<const Tree>(scene)) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayCaster::Hit> RayCaster::first_hit(const Eigen::Vector3d& origin,
                                                   const Eigen::Vector3d& direction, double limit) const {
  return tree_->first_hit(origin, direction, limit);
}

}  // namespace evermap
