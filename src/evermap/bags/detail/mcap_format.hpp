// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace evermap {

// What readers and writers of MCAP share (mcap.dev/spec).

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

struct McapOp {
  enum : unsigned {
    kHeader = 1,
    kFooter = 2,
    kSchema = 3,
    kChannel = 4,
    kMessage = 5,
    kChunk = 6,
    kStatistics = 11,
    kDataEnd = 15,
  };
};

}  // namespace evermap
