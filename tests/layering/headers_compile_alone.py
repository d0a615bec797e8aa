#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""headers_compile_alone.py SRC CLANG [FLAGS]: whether every header below SRC compiles with nothing before it.

Most of the time would go into a few large headers, so what includes the same of these, directly or not, shares them
precompiled. That hides nothing: what they declare is there without it, too.
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from included import all_included

LARGE = re.compile(r"Eigen/.*|filesystem|functional")


def compile_header(command, work, name):
    """What the compiler says of a source that includes the header twice, so that a missing `#pragma once` shows."""
    source = work / f"{name.replace('/', '_')}.cpp"
    source.write_text(f"#include <{name}>\n#include <{name}>\n")
    result = subprocess.run([*command, "-fsyntax-only", str(source)], capture_output=True, text=True)
    return "" if result.returncode == 0 else f"{name} does not compile alone:\n{result.stderr}"


def compile_group(command, work, large, names):
    """The same of all headers that include the same large ones."""
    if large:
        precompiled = work / f"{names[0].replace('/', '_')}.pch"
        subprocess.run([*command, "-x", "c++-header", "-fpch-instantiate-templates", "-", "-o", str(precompiled)], check=True,
                       text=True, input="".join(f"#include <{header}>\n" for header in sorted(large)))
        command = [*command, "-include-pch", str(precompiled)]
    return [compile_header(command, work, name) for name in names]


def main():
    src, command = pathlib.Path(sys.argv[1]), [*sys.argv[2:], f"-I{sys.argv[1]}"]
    names = sorted(str(header.relative_to(src)) for header in src.rglob("*.hpp"))
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        work = pathlib.Path(folder)
        alike = {}
        for name in names:
            alike.setdefault(frozenset(filter(LARGE.fullmatch, all_included(src, name))), []).append(name)
        groups = pool.map(lambda group: compile_group(command, work, *group), alike.items())
        said = "".join(text for group in groups for text in group)
    print(f"{said}{len(names)} headers")
    sys.exit(1 if said else 0)


if __name__ == "__main__":
    main()
