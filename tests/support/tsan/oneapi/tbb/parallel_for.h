// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

#include <oneapi/tbb/blocked_range.h>

/// Takes the place of TBB's parallel_for where ThreadSanitizer watches. It cannot see how TBB's compiled part
/// hands work from thread to thread, and takes every hand-over for a race; of plain threads it sees all. The
/// pieces are dealt out to the threads in turn, so that neighbours run side by side.
namespace tbb {

template <class Index, class Work>
void parallel_for(Index first, Index last, const Work& work) {
  constexpr Index kThreads = 4;
  std::vector<std::jthread> threads;
  for (Index thread = 0; thread < kThreads; ++thread) {
    threads.emplace_back([&work, thread, first, last] {
      for (Index i = first + thread; i < last; i += kThreads) work(i);
    });
  }
}

template <class Value, class Body>
void parallel_for(const blocked_range<Value>& range, const Body& body) {
  const auto grain = static_cast<Value>(range.grainsize());
  const Value pieces = (range.end() - range.begin() + grain - 1) / grain;
  parallel_for(Value{0}, pieces, [&](Value piece) {
    const Value begin = range.begin() + piece * grain;
    body(blocked_range<Value>(begin, std::min(range.end(), begin + grain), range.grainsize()));
  });
}

}  // namespace tbb
