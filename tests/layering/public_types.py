#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""public_types.py SRC: prints the types that <evermap/evermap.hpp> gives, and fails beyond twenty.

A header under detail/ is an internal: its types are not promised, so they do not count.
"""
import pathlib
import re
import sys

MOST = 20


def public_headers(src, header, seen):
    if header in seen or "/detail/" in header:
        return
    seen.append(header)
    for included in re.findall(r"^#include <(evermap/[^>]+)>", (src / header).read_text(), re.M):
        public_headers(src, included, seen)


def main():
    src = pathlib.Path(sys.argv[1])
    headers = []
    public_headers(src, "evermap/evermap.hpp", headers)
    types = []
    for header in headers:  # at namespace scope nothing is indented
        types += re.findall(r"^(?:class|struct|enum class) (\w+)(?! *;)\b[^;]*$", (src / header).read_text(), re.M)
    print(len(types), "public types:", ", ".join(sorted(types)))
    return 0 if 5 < len(types) <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
