// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/io/detail/point_time.hpp>

namespace evermap {
namespace {

TEST(PointTime, TheUnitIsTheOneThatMakesASweep) {
  for (const double sweep : {0.02, 0.05, 0.1, 0.2, 0.5}) {
    for (const double unit : {1.0, 1e-3, 1e-6, 1e-9}) {
      const double span = sweep / unit * (sweep < 0.1 ? 1.001 : 0.999);
      for (const Scalar type : {Scalar::kFloat32, Scalar::kFloat64, Scalar::kUint32, Scalar::kUint64}) {
        if (unit == 1.0 && !is_floating(type)) continue;  // whole seconds tell nothing within a sweep
        EXPECT_EQ(seconds_per_tick(type, span), unit) << sweep;
      }
    }
  }
}

TEST(PointTime, WhatIsNoSweepInAnyUnitKeepsTheTypesUnit) {
  for (const double span : {0.0, 1e-3, 1.0, 10.0, 1e6, 1e10}) {
    EXPECT_EQ(seconds_per_tick(Scalar::kFloat64, span), 1) << span;
    EXPECT_EQ(seconds_per_tick(Scalar::kUint32, span), 1e-9) << span;
  }
}

TEST(PointTime, IsDescribedInOneLine) {
  EXPECT_EQ((PointTime{"timestamp", Scalar::kFloat64, 1e-9, 0, 0.09984}.describe()),
            "field 'timestamp' (float64) in nanoseconds, 0.0998 s from first to last");
}

}  // namespace
}  // namespace evermap
