// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/experiment.hpp"

#include <system_error>

namespace evermap {

std::vector<double> leaves_of(const Setup& setup) {
  if (!setup.leaves.empty()) return setup.leaves;
  return setup.is_quick ? std::vector{0.4} : std::vector{0.4, 0.2};
}

std::string why_left_out(const Setup& setup, const std::string& folder) {
  if (setup.data.empty()) return "the part on real data (" + folder + ") is left out: no --data is given";
  std::error_code error;
  if (std::filesystem::is_directory(setup.data / folder, error)) return "";
  return "the part on real data is left out: there is no folder " + (setup.data / folder).string();
}

}  // namespace evermap
