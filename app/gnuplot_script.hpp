// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plot.hpp"

namespace evermap {

/// The commands that draw the panels to plot.png and plot.svg in gnuplot's working folder. All text of the
/// plots is quoted and drawn as it is, whatever its characters mean to gnuplot.
/// REQUIRES: sizes agree, and every panel has a finite value.
std::string gnuplot_script(const std::vector<Plot>& panels);

/// The text as a string of gnuplot's; control characters become blanks.
std::string gnuplot_quoted(std::string_view text);

}  // namespace evermap
