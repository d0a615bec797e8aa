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
# GCC 12 warns of values that its own AVX-512 headers leave undefined on purpose (GCC bug 105593).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13 AND
    EVERMAP_ARCH MATCHES "native|avx512|v4")
  target_compile_options(evermap_warnings INTERFACE -Wno-maybe-uninitialized)
endif()
