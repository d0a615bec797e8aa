// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/selected_scans.hpp>

namespace evermap {

std::optional<Scan> SelectedScans::next() {
  while (std::optional<Scan> scan = next_undamaged()) {
    const double time = scan->time.value_or(static_cast<double>(all_->index()) * selection_.scan_period);
    if (!first_) first_ = time;
    const double since_start = time - *first_ - selection_.start;
    constexpr double kRounding = 1e-6;  // [s]
    if (since_start < -kRounding) continue;
    if (since_start > selection_.duration + kRounding) return std::nullopt;
    if (in_time_++ % selection_.every == 0 && all_->index() >= selection_.skip) return scan;
  }
  return std::nullopt;
}

std::optional<Scan> SelectedScans::next_undamaged() {
  constexpr std::size_t kFewInAll = 10;  // one in ten
  while (failure_.empty()) {
    try {
      std::optional<Scan> scan = all_->next();
      if (!scan) break;
      ++given_;
      return scan;
    } catch (const FileError& error) {
      if (damage_.empty()) first_damage_ = std::current_exception();
      damage_.emplace_back(error.what());
      const bool are_many = damage_.size() * kFewInAll > all_->size();
      if (given_ == 0 && (selection_.is_strict || are_many)) throw;
      if (!selection_.is_strict && !are_many) continue;
      failure_ = damage_.back();
      if (damage_.size() > 1) failure_ += " (and " + std::to_string(damage_.size() - 1) + " scans before)";
      failure_ += "; what was done up to there is saved";
    }
  }
  if (given_ == 0 && first_damage_) std::rethrow_exception(std::exchange(first_damage_, nullptr));
  return std::nullopt;
}

std::vector<std::string> SelectedScans::remarks() const {
  std::vector<std::string> remarks = all_->remarks();
  if (!failure_.empty()) return remarks;  // which tells
  for (const std::string& damage : damage_) remarks.push_back("a damaged scan was left out: " + damage);
  return remarks;
}

}  // namespace evermap
