#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Draws what evermap_experiments and the benchmarks wrote.

report.py DIR [--markdown FILE.md]: from the results in DIR, pictures and index.html in DIR, and tables on the
standard output. With --markdown also text and tables into FILE.md, behind its mark, and pictures into a folder
beside it.
report.py FILE.json: the plots of a benchmark, beside the file.
"""
import argparse
import base64
import json
import math
import shutil
import sys
from pathlib import Path

import jinja2

import figures
import sections
from section import Figure, Heading, Table

MARK = "<!-- written by script/experiments -->\n"
# Pictures of the real drives stay out of the text: their data are not ours to spread.
NOT_TO_SPREAD = ("a_drive_", "b_redlight_")


class ReportError(Exception):
    """One line that says which file is wrong, and why."""


def read(path):
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReportError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise ReportError(f"{path}: no valid JSON: {error}; compute it anew") from None


def cell_text(column, value):
    if isinstance(value, str):
        return value
    return f"{value:.{column.digits}f}" if value is not None and math.isfinite(value) else "-"


def best_text(table, index):
    """How the best number of a column is written; None where none is better."""
    column = table.columns[index]
    numbers = [row[index] for row in table.rows if isinstance(row[index], (int, float)) and math.isfinite(row[index])]
    return cell_text(column, column.best(numbers)) if column.best and numbers else None


def html_table(table):
    """Rows of (text, class) for the template."""
    best = [best_text(table, i) for i in range(len(table.columns))]
    kinds = ["" if any(isinstance(row[i], str) for row in table.rows) else "number" for i in range(len(table.columns))]
    rows = []
    for row in table.rows:
        texts = [cell_text(column, value) for column, value in zip(table.columns, row)]
        rows.append([(text, kind + (" best" if text == mark and not isinstance(value, str) else ""))
                     for text, kind, mark, value in zip(texts, kinds, best, row)])
    return {"caption": table.caption, "head": [(c.title, k) for c, k in zip(table.columns, kinds)], "rows": rows}


def embedded(path):
    kind = "svg+xml" if path.suffix == ".svg" else path.suffix[1:]
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def write_page(folder, title, told):
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True,
                                     trim_blocks=True, lstrip_blocks=True)
    environment.tests |= {"table": lambda b: isinstance(b, Table), "figure": lambda b: isinstance(b, Figure),
                          "heading": lambda b: isinstance(b, Heading)}
    environment.filters |= {"html_table": html_table, "embedded": lambda b: embedded(folder / b.file)}
    text = environment.get_template("page.html.j2").render(title=title, sections=told)
    (folder / "index.html").write_text(text, encoding="utf-8")


def aligned(table):
    """A table for a terminal."""
    texts = [[c.title for c in table.columns]]
    texts += [[cell_text(column, value) for column, value in zip(table.columns, row)] for row in table.rows]
    widths = [max(len(row[i]) for row in texts) for i in range(len(table.columns))]
    is_text = [[i < len(table.rows[0]) and isinstance(row[i], str) for i in range(len(widths))]
               for row in [table.rows[0], *table.rows]]
    lines = ["".join((text.ljust(width) if left else text.rjust(width)) + "  "
                     for text, width, left in zip(row, widths, lefts)) for row, lefts in zip(texts, is_text)]
    return "\n".join([table.caption, *lines]) + "\n"


def markdown(section, pictures):
    text = f"## {section.title}\n\n"
    for block in section.blocks:
        if isinstance(block, Heading):
            text += f"### {block.text}\n\n"
        elif isinstance(block, Figure):
            if not (block.file.startswith(NOT_TO_SPREAD) and block.file.endswith(".png")):
                text += f"![{block.caption}]({pictures}/{block.file})\n\n"
        elif isinstance(block, Table):
            lines = [[c.title for c in block.columns], ["---"] * len(block.columns)]
            lines += [[cell_text(c, value) for c, value in zip(block.columns, row)] for row in block.rows]
            text += "\n".join(f"| {' | '.join(line)} |" for line in lines).replace(" --- ", "---")
            text += f"\n\n*{block.caption}*\n\n"
        else:
            text += block + "\n\n"
    return text + (f"```sh\n{section.command}\n```\n\n" if section.command else "")


def write_markdown(folder, file, told):
    """Pictures go into a folder beside the file that has its name."""
    pictures = file.with_suffix("")
    text = "".join(markdown(section, pictures.name) for section in told)
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    for section in told:
        for block in section.blocks:
            if isinstance(block, Figure) and f"({pictures.name}/{block.file})" in text:
                shutil.copy(folder / block.file, pictures)
    before = file.read_text(encoding="utf-8").partition(MARK)[0] if file.exists() else ""
    file.write_text(before + MARK + "\n" + text.rstrip() + "\n", encoding="utf-8")


def report(folder, markdown_file):
    names = [name for name in sections.TELL if (folder / f"{name}.json").exists()]
    if not names:
        raise ReportError(f"{folder}: there are no results of evermap_experiments")
    told, results = [], []
    for name in names:
        path = folder / f"{name}.json"
        result = read(path)
        try:
            told.append(sections.tell(name, result, folder))
        except (KeyError, TypeError, IndexError, AttributeError) as error:
            raise ReportError(f"{path}: no result of this experiment: {error!r}; compute it anew") from None
        results.append(result)
    title = "evermap: a demonstration" if names == ["demo"] else "evermap: maps that stay true"
    for section in told:
        tables = section.printed or [b for b in section.blocks if isinstance(b, Table)]
        print(f"\n== {section.title}\n\n" + "\n".join(aligned(table) for table in tables), end="")
    if names != ["demo"]:
        told = [sections.overview(told), *told, sections.method(results)]
    write_page(folder, title, told)
    if markdown_file:
        write_markdown(folder, markdown_file, told)
    if names == ["demo"]:
        print(f"\nMaps, pictures and index.html are in {folder}/")
    else:
        print(f"\npage     {folder / 'index.html'}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--markdown", type=Path, metavar="FILE.md")
    arguments = parser.parse_args(arguments)
    try:
        if arguments.results.is_dir():
            report(arguments.results, arguments.markdown)
            return 0
        for name, panels in read(arguments.results)["figures"].items():
            figures.draw_panels(arguments.results.parent / f"{name}.svg", panels)
        return 0
    except ReportError as error:
        print(f"report.py: {error}", file=sys.stderr)
    except (KeyError, TypeError) as error:
        print(f"report.py: {arguments.results}: no plots of a benchmark: {error!r}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
