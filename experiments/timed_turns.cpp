// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/timed_turns.hpp"

#include <semaphore>
#include <thread>

#include <oneapi/tbb/global_control.h>

#include "cpu_time.hpp"

namespace evermap {
namespace {

/// A thread that work is handed to.
class Lane {
 public:
  Lane() = default;
  Lane(const Lane&) = delete;
  Lane& operator=(const Lane&) = delete;
  ~Lane() {
    work_ = nullptr;
    start_.release();
  }

  /// Returns when the work is done.
  void run(const std::function<void()>& work) {
    work_ = &work;
    start_.release();
    done_.acquire();
  }

 private:
  void loop() {
    for (start_.acquire(); work_ != nullptr; start_.acquire()) {
      (*work_)();
      done_.release();
    }
  }

  const std::function<void()>* work_ = nullptr;
  std::binary_semaphore start_{0};
  std::binary_semaphore done_{0};
  std::jthread thread_{[this] { loop(); }};
};

}  // namespace

std::vector<std::vector<double>> time_in_turns(const Mappers& mappers, std::size_t scans,
                                               const std::function<AlignedScan(std::size_t)>& next) {
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  std::vector<std::vector<double>> seconds(mappers.size());
  std::vector<Lane> lanes(mappers.size());
  for (std::size_t i = 0; i < scans; ++i) {
    const AlignedScan aligned = next(i);
    for (std::size_t c = 0; c < mappers.size(); ++c) {
      const auto integrate = mappers[c]->prepare(aligned.scan, aligned.T_map_sensor);
      const double begin = cpu_seconds();
      lanes[c].run(integrate);
      const double time = cpu_seconds() - begin;
      const bool is_warm = 3 * i >= scans;
      if (is_warm) seconds[c].push_back(time);
    }
  }
  return seconds;
}

}  // namespace evermap
