// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace evermap {

/// The server cannot be set up: an address in use, a certificate that cannot be read.
class WebError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where and to whom pages are served.
struct WebOptions {
  std::string address = "127.0.0.1";  ///< any but a loopback address needs a token, and gets TLS
  std::uint16_t port = 7447;          ///< 0: any that is free
  std::string token;                  ///< whoever does not have it is refused; empty: none is needed
  std::filesystem::path certificate;  ///< PEM; empty: one is made for this run
  std::filesystem::path key;          ///< PEM, of the certificate
};

/// Whether an address, or a name, is this machine's own, which no other can reach.
bool is_loopback(std::string_view address);

/// What a token may consist of.
inline constexpr const char* kTokenLetters =
    "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ-_";
/// A token that nobody can guess. Throws WebError.
std::string make_token();

struct WebRequest {
  std::string method;
  std::string path;  ///< without what follows a question mark
  std::string body;
};

struct WebReply {
  unsigned status = 200;
  std::string type;  ///< of the body: "text/html"
  std::string body;
};

/// Takes the reply to a request, from any thread, once; later than the server it does nothing.
using WebRespond = std::function<void(WebReply reply)>;
/// Called in threads of the server's, several at once; what it throws is an internal error (500).
using WebHandler = std::function<void(const WebRequest& request, WebRespond respond)>;

/// What the server refused or cut off.
struct WebCounts {
  std::size_t requests = 0;   ///< that were answered by the handler
  std::size_t malformed = 0;  ///< no HTTP, or too large
  std::size_t foreign = 0;    ///< of a page from elsewhere, or by another name of this machine
  std::size_t denied = 0;     ///< without the token
  std::size_t crowded = 0;    ///< connections beyond the most that are served at once
  std::size_t slow = 0;       ///< listeners that did not keep up; they come again
};

/// Serves HTTP and WebSockets (at /api/live) to browsers, over TLS unless on a loopback address.
///
/// Answers nobody but pages of its own: a request that names another host, or that another site's page makes,
/// is refused, so that no page on the web reaches a robot through its engineer's browser. With a token, that
/// must come as `Authorization: Bearer`, as a cookie, or once as `/?token=`, which sets the cookie; ten wrong
/// ones within a minute close the door to that address for the rest of it. Requests are small and connections
/// few; who is slower than 30 s is cut off.
///
/// All functions may be called from several threads at once.
class WebServer {
 public:
  /// Begins to serve. Throws WebError.
  WebServer(const WebOptions& options, WebHandler handler);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  std::uint16_t port() const;
  /// What to open in a browser, with the token.
  const std::string& url() const;
  /// SHA-256 of the certificate that was made; empty without one.
  const std::string& fingerprint() const;

  /// Sends a message to each listener. One that is far behind is cut off: it comes again and asks for all.
  void send_text(std::string text);
  void send_binary(std::string bytes);
  std::size_t listeners() const;
  WebCounts counts() const;

 private:
  class Service;

  std::unique_ptr<Service> service_;
};

}  // namespace evermap
