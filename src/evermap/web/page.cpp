// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>

#include <evermap/web/detail/page.hpp>

// The file becomes part of the library as it is.
asm(".section .rodata\n"
    ".global evermap_page_begin\n"
    "evermap_page_begin:\n"
    ".incbin \"" EVERMAP_PAGE
    "\"\n"
    ".global evermap_page_end\n"
    "evermap_page_end:\n"
    ".previous\n");

extern "C" {
extern const char evermap_page_begin[];  // NOLINT(modernize-avoid-c-arrays): a place, of unknown size
extern const char evermap_page_end[];    // NOLINT(modernize-avoid-c-arrays)
}

namespace evermap {

std::string_view page() {
  return {evermap_page_begin, static_cast<std::size_t>(evermap_page_end - evermap_page_begin)};
}

}  // namespace evermap
