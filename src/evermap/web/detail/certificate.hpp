// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace evermap {

/// A certificate that vouches for itself, with its key; both PEM.
struct Certificate {
  std::string certificate;
  std::string key;
  std::string fingerprint;  ///< SHA-256, as browsers show it
};

/// Makes one for this machine's name, valid for a year. Throws WebError.
Certificate make_certificate();

}  // namespace evermap
