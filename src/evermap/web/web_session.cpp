// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <type_traits>

#include <evermap/files/detail/background.hpp>
#include <evermap/web/detail/web_session.hpp>

namespace evermap {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::chrono::seconds kPatience(30);
constexpr std::size_t kMostHeader = 16 << 10;  // [bytes]
constexpr std::size_t kMostBody = 64 << 10;    // [bytes]
constexpr std::size_t kMostHeard = 4 << 10;    // [bytes] of a listener's message
constexpr std::size_t kMostUnsent = 32 << 20;  // [bytes] for a listener
constexpr std::size_t kMostConnections = 64;
constexpr const char* kLivePath = "/api/live";

/// A page fetches from its own server alone, and is shown in no other page.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string text(beast::string_view view) { return {view.data(), view.size()}; }

/// Whether what came is no request, rather than that none came any more.
bool is_malformed(error_code failed) {
  return failed && failed != http::error::end_of_stream &&
         failed.category() == http::make_error_code(http::error::bad_method).category();
}

/// Counts a connection while it lasts, whatever it becomes.
class Seat {
 public:
  explicit Seat(WebHub& hub) : hub_(hub) { ++hub_.connections; }
  ~Seat() { --hub_.connections; }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

 private:
  WebHub& hub_;
};

Response plain(const Request& request, http::status status, const std::string& words) {
  Response response(status, request.version());
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = words + "\n";
  return response;
}

/// Hears what the server says, until it is far behind.
template <class Stream>
class ListeningSession : public WebSession, public std::enable_shared_from_this<ListeningSession<Stream>> {
 public:
  ListeningSession(Stream stream, WebHub& hub, std::shared_ptr<Seat> seat)
      : stream_(std::move(stream)), hub_(hub), seat_(std::move(seat)) {}

  void run(const Request& request) {
    beast::get_lowest_layer(stream_).expires_never();  // a WebSocket has its own timeouts
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream_.read_message_max(kMostHeard);
    stream_.async_accept(request, [self = this->shared_from_this()](error_code failed) {
      if (failed) return;
      self->hub_.listeners.insert(self);
      self->hub_.listener_count = self->hub_.listeners.size();
      self->read();
    });
  }

  void send(const std::shared_ptr<const WebMessage>& message) override {
    unsent_ += message->bytes.size();
    if (unsent_ > kMostUnsent) {
      hub_.count(&WebCounts::slow);
      return leave();
    }
    queue_.push_back(message);
    if (queue_.size() == 1) write();
  }

 private:
  /// What a listener says is not needed, but that it is still there is.
  void read() {
    stream_.async_read(heard_, [self = this->shared_from_this()](error_code failed, std::size_t) {
      if (failed == websocket::error::message_too_big || failed == websocket::error::buffer_overflow)
        self->hub_.count(&WebCounts::malformed);
      if (failed) return self->leave();
      self->heard_.clear();
      self->read();
    });
  }

  void write() {
    stream_.text(queue_.front()->is_text);
    stream_.async_write(asio::buffer(queue_.front()->bytes),
                        [self = this->shared_from_this()](error_code failed, std::size_t) {
                          if (failed) return self->leave();
                          self->unsent_ -= self->queue_.front()->bytes.size();
                          self->queue_.pop_front();
                          if (!self->queue_.empty()) self->write();
                        });
  }

  void leave() {
    hub_.listeners.erase(this->shared_from_this());
    hub_.listener_count = hub_.listeners.size();
    beast::get_lowest_layer(stream_).close();
  }

  websocket::stream<Stream> stream_;
  WebHub& hub_;
  std::shared_ptr<Seat> seat_;
  beast::flat_static_buffer<kMostHeard> heard_;
  std::deque<std::shared_ptr<const WebMessage>> queue_;  ///< the first is under way
  std::size_t unsent_ = 0;                               ///< [bytes]
};

/// Answers requests, one after the other.
template <class Stream>
class RequestSession : public WebSession, public std::enable_shared_from_this<RequestSession<Stream>> {
  static constexpr bool kIsTls = std::is_same_v<Stream, TlsStream>;

 public:
  RequestSession(Stream stream, WebHub& hub)
      : stream_(std::move(stream)), hub_(hub), seat_(std::make_shared<Seat>(hub)) {
    error_code unknown;
    address_ =
        beast::get_lowest_layer(stream_).socket().remote_endpoint(unknown).address().to_string(unknown);
  }

  void run() {
    if constexpr (kIsTls) {
      beast::get_lowest_layer(stream_).expires_after(kPatience);
      stream_.async_handshake(asio::ssl::stream_base::server,
                              [self = this->shared_from_this()](error_code failed) {
                                if (failed) return self->hub_.count(&WebCounts::malformed);
                                self->read();
                              });
    } else {
      read();
    }
  }

 private:
  void read() {
    parser_.emplace();
    parser_->header_limit(kMostHeader);
    parser_->body_limit(kMostBody);
    beast::get_lowest_layer(stream_).expires_after(kPatience);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = this->shared_from_this()](error_code failed, std::size_t) { self->take(failed); });
  }

  void take(error_code failed) {
    if (failed == http::error::body_limit || failed == http::error::header_limit) {
      hub_.count(&WebCounts::malformed);
      return write(plain({}, http::status::payload_too_large, "too large"), true);
    }
    if (is_malformed(failed)) {
      hub_.count(&WebCounts::malformed);
      return write(plain({}, http::status::bad_request, "this is no HTTP"), true);
    }
    if (failed) return close();
    request_ = parser_->release();
    const std::string target = text(request_.target());
    const std::size_t mark = std::min(target.find('?'), target.size());
    const std::string path = target.substr(0, mark);
    const auto header = [&](http::field field) { return text(request_[field]); };
    const Door::Verdict verdict = hub_.door.judge(
        {address_, header(http::field::host), header(http::field::origin), header(http::field::authorization),
         header(http::field::cookie), mark < target.size() ? target.substr(mark + 1) : ""},
        now());
    switch (verdict) {
      case Door::Verdict::kForeign:
        hub_.count(&WebCounts::foreign);
        return write(plain(request_, http::status::forbidden,
                           "only pages of this server may ask, by the name localhost"));
      case Door::Verdict::kUnknown:
        hub_.count(&WebCounts::denied);
        return write(plain(request_, http::status::unauthorized,
                           "open the address that the server printed, with its token"));
      case Door::Verdict::kShut:
        hub_.count(&WebCounts::denied);
        return write(
            plain(request_, http::status::too_many_requests, "too many wrong tokens; wait a minute"));
      case Door::Verdict::kNewcomer: {
        Response response = plain(request_, http::status::see_other, "");
        response.set(http::field::set_cookie, hub_.door.cookie());
        response.set(http::field::location, "/");
        return write(std::move(response));
      }
      case Door::Verdict::kWelcome:
        break;
    }
    if (websocket::is_upgrade(request_)) {
      if (path != kLivePath) return write(plain(request_, http::status::not_found, "nothing is told here"));
      std::make_shared<ListeningSession<Stream>>(std::move(stream_), hub_, seat_)->run(request_);
      return;
    }
    hand_over(path);
  }

  /// Lets the handler answer, in another thread.
  void hand_over(const std::string& path) {
    hub_.count(&WebCounts::requests);
    const std::shared_ptr<RequestSession> self = this->shared_from_this();
    hub_.waiting.insert(self);
    WebRespond respond = [weak = std::weak_ptr<RequestSession>(self),
                          weak_hub = hub_.weak_from_this()](WebReply reply) {
      const std::shared_ptr<WebHub> hub = weak_hub.lock();
      if (!hub) return;
      asio::post(hub->io, [weak, reply = std::move(reply)]() mutable {
        const std::shared_ptr<RequestSession> session = weak.lock();
        if (session && session->hub_.waiting.erase(session) > 0) session->answer(std::move(reply));
      });
    };
    asio::post(hub_.workers, [hub = &hub_, respond = std::move(respond),
                              request = WebRequest{text(request_.method_string()), path, request_.body()}] {
      step_back();
      try {
        hub->handler(request, respond);
      } catch (const std::exception& error) {
        respond({500, "text/plain; charset=utf-8", std::string(error.what()) + "\n"});
      }
    });
  }

  void answer(WebReply reply) {
    Response response(static_cast<http::status>(reply.status), request_.version());
    response.set(http::field::content_type, reply.type);
    response.body() = std::move(reply.body);
    write(std::move(response));
  }

  void write(Response response, bool is_last = false) {
    response.set(http::field::cache_control, "no-store");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Content-Security-Policy", kContentPolicy);
    response.set("Referrer-Policy", "no-referrer");
    response.keep_alive(!is_last && request_.keep_alive());
    if (request_.method() == http::verb::head) {
      const std::size_t size = response.body().size();
      response.body().clear();
      response.content_length(size);
    } else {
      response.prepare_payload();
    }
    response_ = std::move(response);
    beast::get_lowest_layer(stream_).expires_after(kPatience);
    http::async_write(stream_, response_, [self = this->shared_from_this()](error_code failed, std::size_t) {
      if (failed) return;
      if (self->response_.need_eof()) return self->close();
      self->read();
    });
  }

  void close() {
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().shutdown(tcp::socket::shutdown_send, ignored);
  }

  Stream stream_;
  WebHub& hub_;
  std::shared_ptr<Seat> seat_;
  std::string address_;
  beast::flat_buffer buffer_{kMostHeader + kMostBody};
  std::optional<http::request_parser<http::string_body>> parser_;
  Request request_;
  Response response_;
};

}  // namespace

void start_session(tcp::socket socket, WebHub& hub) {
  if (hub.connections >= kMostConnections) return hub.count(&WebCounts::crowded);
  if (hub.is_tls) {
    std::make_shared<RequestSession<TlsStream>>(TlsStream(std::move(socket), hub.tls), hub)->run();
  } else {
    std::make_shared<RequestSession<PlainStream>>(PlainStream(std::move(socket)), hub)->run();
  }
}

}  // namespace evermap
