// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/web/detail/web_hub.hpp>

namespace evermap {

/// Serves a connection until it ends. In the thread of `hub.io`.
void start_session(boost::asio::ip::tcp::socket socket, WebHub& hub);

}  // namespace evermap
