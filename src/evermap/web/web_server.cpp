// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <thread>
#include <unistd.h>
#include <utility>

#include <evermap/web/detail/certificate.hpp>
#include <evermap/web/detail/web_session.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

/// By which others may call this machine that listens at `address`.
std::string name_of(const std::string& address) {
  std::array<char, 256> host{};
  const bool is_any = address == "0.0.0.0" || address == "::";
  if (is_any && ::gethostname(host.data(), host.size() - 1) == 0) return host.data();
  return address;
}

}  // namespace

class WebServer::Service {
 public:
  Service(const WebOptions& options, WebHandler handler)
      : is_local_(is_loopback(options.address)),
        hub_(std::make_shared<WebHub>(std::move(handler), options.token, !is_local_)) {
    if (!is_local_ && options.token.empty())
      throw WebError("whoever may reach " + options.address + " must show a token: give one");
    if (!is_local_) set_up_tls(options);
    listen(options);
    url_ = (is_local_ ? "http://localhost:" : "https://" + name_of(options.address) + ":") +
           std::to_string(port()) + (options.token.empty() ? "/" : "/?token=" + options.token);
    accept();
    thread_ = std::thread([this] { hub_->io.run(); });
  }
  ~Service() {
    hub_->io.stop();
    thread_.join();
    hub_->workers.stop();
    hub_->workers.join();
    hub_->forget_sessions();
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  const std::string& url() const { return url_; }
  const std::string& fingerprint() const { return fingerprint_; }
  const WebHub& hub() const { return *hub_; }

  void send(WebMessage message) {
    if (hub_->listener_count == 0) return;
    asio::post(hub_->io, [hub = hub_.get(), shared = std::make_shared<const WebMessage>(std::move(message))] {
      const std::vector<std::shared_ptr<WebSession>> listeners(hub->listeners.begin(), hub->listeners.end());
      for (const std::shared_ptr<WebSession>& listener : listeners) listener->send(shared);
    });
  }

 private:
  void set_up_tls(const WebOptions& options) {
    using Context = asio::ssl::context;
    Context& tls = hub_->tls;
    tls.set_options(Context::default_workarounds | Context::no_sslv2 | Context::no_sslv3 | Context::no_tlsv1 |
                    Context::no_tlsv1_1);
    error_code failed;
    if (options.certificate.empty()) {
      const Certificate made = make_certificate();
      fingerprint_ = made.fingerprint;
      tls.use_certificate_chain(asio::buffer(made.certificate), failed);
      if (!failed) tls.use_private_key(asio::buffer(made.key), Context::pem, failed);
      if (failed) throw WebError("the certificate cannot be used: " + failed.message());
      return;
    }
    tls.use_certificate_chain_file(options.certificate.string(), failed);
    if (failed) throw WebError(options.certificate.string() + " is no certificate: " + failed.message());
    tls.use_private_key_file(options.key.string(), Context::pem, failed);
    if (failed) throw WebError(options.key.string() + " is not the certificate's key: " + failed.message());
  }

  void listen(const WebOptions& options) {
    error_code failed;
    const asio::ip::address address =
        asio::ip::make_address(options.address == "localhost" ? "127.0.0.1" : options.address, failed);
    if (failed) throw WebError("\"" + options.address.substr(0, 80) + "\" is no address, such as 0.0.0.0");
    const tcp::endpoint endpoint(address, options.port);
    acceptor_.open(endpoint.protocol(), failed);
    if (!failed) acceptor_.set_option(asio::socket_base::reuse_address(true), failed);
    if (!failed) acceptor_.bind(endpoint, failed);
    if (!failed) acceptor_.listen(asio::socket_base::max_listen_connections, failed);
    if (failed) {
      throw WebError(
          "no page can be served at " + options.address + ":" + std::to_string(options.port) + ": " +
          failed.message() +
          (failed == asio::error::address_in_use ? "; another program is there, choose another --port" : ""));
    }
  }

  void accept() {
    acceptor_.async_accept([this](error_code failed, tcp::socket socket) {
      if (failed == asio::error::operation_aborted) return;
      if (!failed) start_session(std::move(socket), *hub_);
      if (!failed) return accept();
      constexpr std::chrono::milliseconds kPause(100);  // out of file handles, say
      pause_.expires_after(kPause);
      pause_.async_wait([this](error_code ended) {
        if (!ended) accept();
      });
    });
  }

  bool is_local_;
  std::shared_ptr<WebHub> hub_;
  tcp::acceptor acceptor_{hub_->io};
  asio::steady_timer pause_{hub_->io};
  std::string url_;
  std::string fingerprint_;
  std::thread thread_;
};

WebServer::WebServer(const WebOptions& options, WebHandler handler)
    : service_(std::make_unique<Service>(options, std::move(handler))) {}
WebServer::~WebServer() = default;
std::uint16_t WebServer::port() const { return service_->port(); }
const std::string& WebServer::url() const { return service_->url(); }
const std::string& WebServer::fingerprint() const { return service_->fingerprint(); }
void WebServer::send_text(std::string text) { service_->send({true, std::move(text)}); }
void WebServer::send_binary(std::string bytes) { service_->send({false, std::move(bytes)}); }
std::size_t WebServer::listeners() const { return service_->hub().listener_count; }
WebCounts WebServer::counts() const { return service_->hub().counts(); }

}  // namespace evermap
