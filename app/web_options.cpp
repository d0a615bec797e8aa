// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "web_options.hpp"

#include <cstdio>
#include <fstream>
#include <string>

#include <fmt/core.h>

#include <evermap/files/file_error.hpp>

namespace evermap {

void add_page_options(CLI::App& verb, PageOptions& options) {
  verb.add_option("--port", options.web.port, "Port of the page; 0: any that is free")
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--listen", options.web.address,
                  "Address at which others may open the page, too, over TLS and with a token: 0.0.0.0")
      ->type_name("ADDRESS")
      ->capture_default_str();
  verb.add_option("--token-file", options.token_file, "File with the token that opens the page")
      ->type_name("FILE")
      ->default_str("a new one for each run, where others may open the page");
  CLI::Option* certificate =
      verb.add_option("--certificate", options.web.certificate, "Certificate of this machine (PEM)")
          ->type_name("FILE")
          ->default_str("a new one for each run");
  CLI::Option* key = verb.add_option("--key", options.web.key, "Its key (PEM)")->type_name("FILE");
  certificate->needs(key);
  key->needs(certificate);
}

WebOptions web_options_of(const PageOptions& options) {
  WebOptions web = options.web;
  if (!options.token_file.empty()) {
    std::ifstream file(options.token_file);
    if (!std::getline(file, web.token)) throw FileError(options.token_file, "no token can be read from it");
    constexpr std::size_t kShortest = 16;
    if (web.token.size() < kShortest || web.token.find_first_not_of(kTokenLetters) != std::string::npos)
      throw FileError(options.token_file, "a token has at least 16 letters and digits, in the first line");
  } else if (!is_loopback(web.address)) {
    web.token = make_token();
  }
  return web;
}

void print_address(const WebServer& server) {
  fmt::print("page     {}{}\n", server.url(),
             server.fingerprint().empty()
                 ? ""
                 : "\n         its certificate vouches for itself; compare what the browser shows: "
                   "SHA-256 " +
                       server.fingerprint());
  std::fflush(stdout);
}

}  // namespace evermap
