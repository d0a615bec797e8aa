// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <string>
#include <string_view>

namespace evermap {

/// Decides who may ask anything at all: see WebServer. Not thread safe.
class Door {
 public:
  /// What of a request tells who makes it; empty where it does not say.
  struct Visitor {
    std::string address;        ///< of the other side
    std::string host;           ///< header: by which name this server was called
    std::string origin;         ///< header: whose page asks
    std::string authorization;  ///< header
    std::string cookie;         ///< header
    std::string query;          ///< of the path, behind the question mark
  };
  enum class Verdict {
    kWelcome,
    kNewcomer,  ///< welcome, and showed the token in the query: give it the cookie
    kForeign,   ///< another site's page, or this machine under another name
    kUnknown,   ///< without the token
    kShut,      ///< showed wrong tokens too often
  };

  /// With an empty token, all of this machine's own requests are welcome.
  explicit Door(std::string token) : token_(std::move(token)) {}

  /// `now`: [s], never decreasing.
  Verdict judge(const Visitor& visitor, double now);

  /// For Set-Cookie.
  std::string cookie() const;

 private:
  bool is_token(std::string_view text) const;

  std::string token_;
  std::map<std::string, std::deque<double>> wrong_;  ///< [s] when an address last showed wrong tokens
};

}  // namespace evermap
