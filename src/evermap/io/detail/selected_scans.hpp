// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <limits>
#include <memory>

#include <evermap/io/scan_source.hpp>

namespace evermap {

/// Which scans of a sequence are wanted.
struct ScanSelection {
  double start = 0;                                           ///< [s] after the first
  double duration = std::numeric_limits<double>::infinity();  ///< [s]
  std::size_t every = 1;                                      ///< each n-th of these
  double scan_period = 0.1;                                   ///< [s] where scans have no times
  std::size_t skip = 0;                                       ///< the first, counted with those left out
  bool is_strict = false;                                     ///< a damaged scan is an error
};

/// Those scans of another source that are wanted. One that is damaged costs itself: it is left out and
/// remarked; more than a tenth of all end the sequence, and with `is_strict` the first does.
class SelectedScans : public ScanSource {
 public:
  SelectedScans(std::unique_ptr<ScanSource> all, const ScanSelection& selection)
      : all_(std::move(all)), selection_(selection) {}

  std::optional<Scan> next() override;
  std::size_t size() const override { return all_->size(); }
  std::size_t index() const override { return all_->index(); }
  std::string place() const override { return all_->place(); }
  const CloudNotes& notes() const override { return all_->notes(); }
  std::optional<Pose> pose_at(double time) const override { return all_->pose_at(time); }
  std::optional<Eigen::Matrix3d> rotation_at(double time) const override { return all_->rotation_at(time); }
  std::optional<Pose> base_pose() const override { return all_->base_pose(); }
  std::string frame() const override { return all_->frame(); }
  std::vector<std::string> remarks() const override;
  std::string failure() const override { return failure_; }

 private:
  std::optional<Scan> next_undamaged();

  std::unique_ptr<ScanSource> all_;
  ScanSelection selection_;
  std::optional<double> first_;      ///< [s]
  std::size_t in_time_ = 0;          ///< scans between start and end
  std::size_t given_ = 0;            ///< scans
  std::vector<std::string> damage_;  ///< a line for each damaged scan
  std::exception_ptr first_damage_;  ///< while no scan was given
  std::string failure_;
};

}  // namespace evermap
