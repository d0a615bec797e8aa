// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <evermap/web/detail/door.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {
namespace {

constexpr double kMinute = 60;  // [s]
constexpr std::size_t kMostWrong = 10;
constexpr std::size_t kMostAddresses = 1000;
constexpr std::string_view kCookie = "evermap=";
constexpr std::string_view kBearer = "Bearer ";
constexpr std::string_view kTokenInQuery = "token=";

/// "localhost:7447" -> "localhost", "[::1]:7447" -> "::1".
std::string_view name_of(std::string_view host) {
  if (!host.empty() && host.front() == '[') return host.substr(1, host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

/// The value behind `name` in a list like "a=1; evermap=2"; empty when it is not there.
std::string_view value_of(std::string_view list, std::string_view name, char separator) {
  while (!list.empty()) {
    const std::size_t end = list.find(separator);
    std::string_view item = list.substr(0, end);
    while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
    if (item.starts_with(name)) return item.substr(name.size());
    if (end == std::string_view::npos) break;
    list.remove_prefix(end + 1);
  }
  return {};
}

}  // namespace

bool is_loopback(std::string_view address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

std::string make_token() {
  std::array<unsigned char, 24> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1)
    throw WebError("no token can be made (OpenSSL)");
  std::string token;
  for (const unsigned char byte : random) token += kTokenLetters[byte % 64];
  return token;
}

bool Door::is_token(std::string_view text) const {
  // In a time that does not tell how much of it is right.
  return text.size() == token_.size() && CRYPTO_memcmp(text.data(), token_.data(), text.size()) == 0;
}

std::string Door::cookie() const {
  return std::string(kCookie) + token_ + "; HttpOnly; SameSite=Strict; Secure; Path=/";
}

Door::Verdict Door::judge(const Visitor& visitor, double now) {
  if (!visitor.origin.empty()) {
    const std::size_t scheme = visitor.origin.find("://");
    if (scheme == std::string::npos || visitor.origin.substr(scheme + 3) != visitor.host)
      return Verdict::kForeign;
  }
  if (token_.empty()) return is_loopback(name_of(visitor.host)) ? Verdict::kWelcome : Verdict::kForeign;

  const auto known = wrong_.find(visitor.address);
  if (known != wrong_.end()) {
    std::deque<double>& times = known->second;
    while (!times.empty() && times.front() < now - kMinute) times.pop_front();
    if (times.size() >= kMostWrong) return Verdict::kShut;
    if (times.empty()) wrong_.erase(known);
  }
  const std::string_view in_query = value_of(visitor.query, kTokenInQuery, '&');
  if (!in_query.empty() && is_token(in_query)) return Verdict::kNewcomer;
  const std::string_view authorization = visitor.authorization;
  const std::string_view shown = !in_query.empty() ? in_query
                                 : authorization.starts_with(kBearer)
                                     ? authorization.substr(kBearer.size())
                                     : value_of(visitor.cookie, kCookie, ';');
  if (!shown.empty() && is_token(shown)) return Verdict::kWelcome;
  if (!shown.empty()) {
    if (wrong_.size() >= kMostAddresses) wrong_.clear();
    wrong_[visitor.address].push_back(now);
  }
  return Verdict::kUnknown;
}

}  // namespace evermap
