#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""public_types.py SRC: prints the types that <evermap/evermap.hpp> gives, and fails beyond twenty.

A header under detail/ is an internal: its types are not promised, so they do not count.
"""
import pathlib
import re
import sys

from included import all_included

MOST = 20


def main():
    src = pathlib.Path(sys.argv[1])
    types = []
    for header in all_included(src, "evermap/evermap.hpp", without="/detail/"):
        if not header.startswith("evermap/"):
            continue
        # At namespace scope nothing is indented.
        types += re.findall(r"^(?:class|struct|enum class) (\w+)(?! *;)\b[^;]*$", (src / header).read_text(), re.M)
    print(len(types), "public types:", ", ".join(sorted(types)))
    return 0 if 5 < len(types) <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
