// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/registration.h>

#include <evermap/geometry/pose.hpp>

namespace evermap {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

/// One point a cube of this edge [m], as is usual; all points for 0.
inline PclCloud::Ptr pcl_cloud_of(const std::vector<Eigen::Vector3d>& points, double edge) {
  auto all = pcl::make_shared<PclCloud>();
  all->reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3f q = p.cast<float>();
    all->push_back({q.x(), q.y(), q.z()});
  }
  if (edge == 0) return all;
  auto thinned = pcl::make_shared<PclCloud>();
  pcl::VoxelGrid<pcl::PointXYZ> filter;
  const auto size = static_cast<float>(edge);
  filter.setLeafSize(size, size, size);
  filter.setInputCloud(all);
  filter.filter(*thinned);
  return thinned;
}

/// Aligns a cloud to the method's target, from `start` on. Returns the transformation where it ended.
inline Eigen::Matrix4d pcl_align(pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>& method,
                                 const PclCloud::Ptr& source, const Pose& start) {
  Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  guess.topLeftCorner<3, 3>() = start.rotation.cast<float>();
  guess.topRightCorner<3, 1>() = start.translation.cast<float>();
  method.setInputSource(source);
  PclCloud moved;
  method.align(moved, guess);
  return method.getFinalTransformation().cast<double>();
}

}  // namespace evermap
