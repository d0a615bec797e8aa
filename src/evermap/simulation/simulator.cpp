// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <embree3/rtcore.h>

#include <evermap/geometry/voxel_key.hpp>
#include <evermap/simulation/simulator.hpp>

namespace evermap {
namespace {

using Device = std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)>;
using TriangleTree = std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)>;

/// Uniform in (0, 1], number `index` of the sequence that `seed` names.
double uniform(std::uint64_t seed, std::uint64_t index) {
  constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15U;  // of SplitMix64
  const std::uint64_t bits = hash_bits(hash_bits(seed + kGoldenRatio) + index * kGoldenRatio);
  return static_cast<double>((bits >> 11) + 1) * 0x1p-53;
}

/// Standard normal (Box and Muller, 1958), number `index` of the sequence that `seed` names. Unlike
/// std::normal_distribution it is the same with every standard library and in any order of calls.
double standard_normal(std::uint64_t seed, std::uint64_t index) {
  const double radius = std::sqrt(-2 * std::log(uniform(seed, 2 * index)));
  return radius * std::cos(2 * std::numbers::pi * uniform(seed, 2 * index + 1));
}

Eigen::Vector3d middle(const Scene& scene) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& vertex : scene.vertices) bounds.extend(vertex);
  return bounds.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(bounds.center());
}

}  // namespace

/// Embree finds the triangle in single precision, around the scene's middle to stay precise in far-away
/// frames; the range is then computed from the triangle's plane in double precision.
class Simulator::RayCaster {
 public:
  struct Hit {
    double range;  ///< [m]
    int object;
  };

  explicit RayCaster(const Scene& scene);

  /// REQUIRES: `direction` has length 1.
  std::optional<Hit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

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
Simulator::RayCaster::RayCaster(const Scene& scene)
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

void Simulator::RayCaster::build(const Scene& scene) {
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

std::optional<Simulator::RayCaster::Hit> Simulator::RayCaster::first_hit(
    const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
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
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = 0xFFFFFFFFU;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(tree_.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  const Plane& plane = planes_[query.hit.primID];
  const double single = query.ray.tfar;
  const double exact = (plane.offset - plane.normal.dot(local)) / plane.normal.dot(direction);
  // A ray within the plane has no crossing with it; there the single precision must do.
  const bool usable = std::abs(exact - single) < 1e-3 * (1 + single);
  return Hit{usable ? exact : single, object_[query.hit.primID]};
}

Simulator::Simulator(const Scene& scene) : ray_caster_(std::make_unique<const RayCaster>(scene)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

Scan Simulator::scan(const Pose& T_map_sensor, const LidarModel& lidar, std::uint64_t seed) const {
  Scan scan;
  for (const BeamHit& hit : hits(T_map_sensor, lidar)) {
    const double noise = lidar.range_sigma * standard_normal(seed, static_cast<std::uint64_t>(hit.beam));
    scan.p_sensor.emplace_back((hit.range + noise) * lidar.direction(hit.beam));
  }
  return scan;
}

std::vector<BeamHit> Simulator::hits(const Pose& T_map_sensor, const LidarModel& lidar) const {
  std::vector<BeamHit> hits;
  for (int beam = 0; beam < lidar.beams(); ++beam) {
    const Eigen::Vector3d direction = T_map_sensor.rotation * lidar.direction(beam);
    const auto hit = ray_caster_->first_hit(T_map_sensor.translation, direction);
    if (!hit || hit->range < lidar.min_range || hit->range > lidar.max_range) continue;
    hits.push_back({beam, hit->object, hit->range, T_map_sensor.translation + hit->range * direction});
  }
  return hits;
}

std::optional<double> Simulator::range(const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) const {
  const auto hit = ray_caster_->first_hit(origin, direction.normalized());
  return hit ? std::optional(hit->range) : std::nullopt;
}

}  // namespace evermap
