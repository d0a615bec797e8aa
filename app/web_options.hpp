// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

#include <evermap/web/web_server.hpp>

namespace evermap {

struct PageOptions {
  WebOptions web;
  std::filesystem::path token_file;  ///< empty: none is needed, or one is made
};

/// --port, --listen, --token-file, --certificate, --key.
void add_page_options(CLI::App& verb, PageOptions& options);

/// With the token, read or made. Throws FileError.
WebOptions web_options_of(const PageOptions& options);

/// Says where the page is.
void print_address(const WebServer& server);

}  // namespace evermap
