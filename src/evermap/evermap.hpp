// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// All that a program needs to keep a map. What lies under detail/ is not promised from one version to the
// next.
#include <evermap/files/file_error.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/map/map_difference.hpp>
#include <evermap/map/octree.hpp>
