// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros_options.hpp"

#include <cstdlib>
#include <string>

namespace evermap {

void add_domain_options(CLI::App& verb, unsigned& domain, bool& is_local) {
  constexpr unsigned kLastDomain = 232;  // of those that have ports
  verb.add_option("--domain", domain, "Domain of ROS")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0U, kLastDomain))
      ->type_name("N")
      ->capture_default_str();
  const char* localhost_only = std::getenv("ROS_LOCALHOST_ONLY");
  is_local = localhost_only != nullptr && std::string(localhost_only) == "1";
  verb.add_flag("--local", is_local, "Speak with this machine alone (ROS_LOCALHOST_ONLY=1)");
}

}  // namespace evermap
