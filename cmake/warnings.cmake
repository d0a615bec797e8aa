# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# One interface target carries what every translation unit of this repository is compiled with. It is linked
# PRIVATE, so that nothing of it reaches a project that uses evermap.
add_library(evermap_warnings INTERFACE)
target_compile_options(evermap_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion)
option(EVERMAP_WERROR "Treat warnings as errors" ON)
if(EVERMAP_WERROR)
  target_compile_options(evermap_warnings INTERFACE -Werror)
endif()
