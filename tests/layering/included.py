# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
import re


def all_included(src, header, without=None):
    """The header, which lies below SRC, and all that it includes, directly or not; nothing whose name has `without`."""
    found = []

    def add(name):
        if name in found or (without and without in name):
            return
        found.append(name)
        if name.startswith("evermap/"):
            for included in re.findall(r"^#include <([^>]+)>", (src / name).read_text(), re.MULTILINE):
                add(included)

    add(header)
    return found
