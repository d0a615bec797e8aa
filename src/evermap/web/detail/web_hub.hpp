// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include <evermap/web/detail/door.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {

/// What the server says by itself.
struct WebMessage {
  bool is_text;
  std::string bytes;
};

/// A connection. It lives in the thread of WebHub::io, so it needs no lock.
class WebSession {
 public:
  WebSession() = default;
  virtual ~WebSession() = default;
  WebSession(const WebSession&) = delete;
  WebSession& operator=(const WebSession&) = delete;

  /// For those that listen.
  virtual void send(const std::shared_ptr<const WebMessage>& /*message*/) {}
};

/// What all connections share. They end before it does: `io`, which holds what they wait for, goes first.
class WebHub : public std::enable_shared_from_this<WebHub> {
 public:
  WebHub(WebHandler handle, std::string token, bool is_secure)
      : handler(std::move(handle)), is_tls(is_secure), door(std::move(token)) {}
  ~WebHub() { forget_sessions(); }
  WebHub(const WebHub&) = delete;
  WebHub& operator=(const WebHub&) = delete;

  void count(std::size_t WebCounts::*what) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++(counts_.*what);
  }
  WebCounts counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
  }
  void forget_sessions() {
    listeners.clear();
    waiting.clear();
  }

 private:
  mutable std::mutex mutex_;
  WebCounts counts_;

 public:
  WebHandler handler;
  bool is_tls;
  boost::asio::ssl::context tls{boost::asio::ssl::context::tls_server};
  std::atomic<std::size_t> listener_count = 0;

  // In the thread of `io` alone:
  Door door;
  std::size_t connections = 0;
  std::set<std::shared_ptr<WebSession>> listeners;
  std::set<std::shared_ptr<WebSession>> waiting;  ///< for the handler's reply

  boost::asio::thread_pool workers{2};
  boost::asio::io_context io{1};
};

}  // namespace evermap
