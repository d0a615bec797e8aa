// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <cstdint>
#include <netinet/in.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

namespace evermap {

/// A connection to a server on this machine, byte by byte.
class RawConnection {
 public:
  explicit RawConnection(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{10, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
      throw std::runtime_error("no connection");
  }
  ~RawConnection() { ::close(socket_); }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  void send(const std::string& bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void end() const { ::shutdown(socket_, SHUT_WR); }
  /// What comes until the other side closes, `enough` is among it, or ten seconds pass.
  std::string receive(const std::string& enough = "") const {
    std::string bytes;
    char part[4096];  // NOLINT(modernize-avoid-c-arrays)
    while (enough.empty() || bytes.find(enough) == std::string::npos) {
      const ssize_t size = ::recv(socket_, part, sizeof(part), 0);
      if (size <= 0) break;
      bytes.append(part, static_cast<std::size_t>(size));
    }
    return bytes;
  }

 private:
  int socket_;
};

/// Asks for a WebSocket.
inline std::string upgrade(const std::string& path = "/api/live", const std::string& headers = "") {
  return "GET " + path +
         " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
         headers + "\r\n";
}

/// The whole answer to a request, after which the connection is closed.
inline std::string ask(std::uint16_t port, const std::string& line, const std::string& headers = "",
                       const std::string& body = "") {
  const RawConnection connection(port);
  connection.send(line + " HTTP/1.1\r\nConnection: close\r\n" +
                  (headers.find("Host:") == std::string::npos ? "Host: localhost\r\n" : "") + headers +
                  (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" +
                  body);
  return connection.receive();
}

}  // namespace evermap
