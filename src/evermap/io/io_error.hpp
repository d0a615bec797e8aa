// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/files/file_error.hpp>

namespace evermap {

using IoError = FileError;

}  // namespace evermap
