# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a section of the page is made of, and how a comparison of mappers is told."""
from dataclasses import dataclass, field
from typing import Callable, Optional

import figures

OCTOMAP, EVERMAP = "OctoMap", "evermap default"
TOLERANCES = ("0.1", "0.2", "0.5", "l/2", "l")
NOTHING = float("nan")


@dataclass
class Heading:
    text: str


@dataclass
class Figure:
    file: str  # in the folder of the results
    caption: str


@dataclass
class Column:
    title: str
    digits: int = 0
    best: Optional[Callable] = None  # max or min


@dataclass
class Table:
    caption: str
    columns: list
    rows: list  # of text and numbers; None and NaN say that there is nothing to say


@dataclass
class Section:
    title: str
    blocks: list = field(default_factory=list)
    glances: list = field(default_factory=list)  # rows of the overview's first table
    aims: list = field(default_factory=list)  # rows of its second: data, aim, reached, whether it is met
    command: str = ""
    is_quick: bool = False
    printed: list = field(default_factory=list)  # tables for the terminal; none: all

    def aim(self, where, what, reached, is_met):
        text = reached if isinstance(reached, str) else f"{reached:.4f}".replace("nan", "-")
        self.aims.append([where, what, text, "yes" if is_met else "NO"])

    def aim_at_least(self, where, what, aimed, reached):
        self.aim(where, f"{what} at least {aimed}", reached, reached >= aimed)

    def aim_at_most(self, where, what, aimed, reached):
        self.aim(where, f"{what} at most {aimed}", reached, reached <= aimed)


def number(value):
    return NOTHING if value is None else value


def ratio(a, b):
    return a / b if b else NOTHING


def mapper_of(result, name):
    return next((mapper for mapper in result["mappers"] if mapper["name"] == name), None)


def at_end(result, name, metric):
    mapper = mapper_of(result, name)
    if mapper is None:
        return NOTHING
    return number(mapper["end"].get(metric, mapper["rows"][-1].get(metric)))


def along(result, name, metric):
    return [number(row[metric]) for row in mapper_of(result, name)["rows"]]


def curves(result, metric):
    return {m["name"]: [[row["scan"], row[metric]] for row in m["rows"]] for m in result["mappers"]}


def names_of(result):
    names = [mapper["name"] for mapper in result["mappers"]]
    if OCTOMAP in names and "UFOMap" not in names:
        names.insert(names.index(OCTOMAP) + 1, "UFOMap")
    return names


def metric_table(result, caption, columns, metrics):
    rows = [[name + ("" if mapper_of(result, name) else " (not installed)"),
             *(at_end(result, name, metric) for metric in metrics)] for name in names_of(result)]
    return Table(caption, [Column("map"), *columns], rows)


def quality_table(result, caption):
    high = [Column(title, 4, max) for title in ("SA", "DA", "AA", "COV 0.2", "ACC 0.2")]
    low = [Column(title, 3, min) for title in ("truth to map [m]", "map to truth [m]", "AHD [m]")]
    uncropped = [Column("COV 0.2, uncropped", 4, max), Column("AHD, uncropped [m]", 3, min)]
    return metric_table(result, caption, high + low + uncropped,
                        ["SA", "DA", "AA", "COV 0.2", "ACC 0.2", "truth to map", "map to truth", "AHD",
                         "uncropped COV 0.2", "uncropped AHD"])


def tolerance_table(result, caption):
    metrics = [f"{kind} {tolerance}" for kind in ("COV", "ACC") for tolerance in TOLERANCES]
    return metric_table(result, caption, [Column(metric, 3, max) for metric in metrics], metrics)


def verdict(result):
    """The outcome in a sentence or two."""
    kept, erased, apart = ([at_end(result, name, metric) for name in (OCTOMAP, EVERMAP)] for metric in ("SA", "DA", "AHD"))
    if kept[0] != kept[0]:
        return (f"evermap kept {100 * kept[1]:.1f} % of the surface that did not change and erased {100 * erased[1]:.1f} % "
                f"of what was gone; map and truth were {apart[1]:.3f} m apart (AHD).")
    text = f"Of the surface that did not change, OctoMap kept {100 * kept[0]:.1f} %, evermap {100 * kept[1]:.1f} %."
    if erased[1] == erased[1]:
        text += f" Of what was gone, OctoMap erased {100 * erased[0]:.1f} %, evermap {100 * erased[1]:.1f} %."
    return text + f" Map and truth were {apart[0]:.3f} m apart with OctoMap, {apart[1]:.3f} m with evermap (AHD)."


def tell_comparison(section, folder, name, unit, metrics, figure, view, shaded=()):
    """Draws a comparison's pictures and adds them, its tables and its line of the overview."""
    title, result = unit["title"], unit["result"]
    about = f"{title}, {result['scans']} scans"
    section.glances.append([title, *(at_end(result, mapper, metric) for metric in ("SA", "DA", "AHD")
                                     for mapper in (OCTOMAP, EVERMAP))])
    section.blocks += [Heading(title), verdict(result)]
    if "view" in result["mappers"][0]:
        figures.draw_views(folder / f"{name}_views.png", result)
        section.blocks.append(Figure(f"{name}_views.png", f"{view} ({about})."))
    panels = [{"title": metric_title, "x": "scan", "y": "distance [m]" if metric == "AHD" else "fraction",
               "series": curves(result, metric), "shaded": shaded} for metric, metric_title in metrics]
    figures.draw_panels(folder / f"{name}.svg", panels)
    section.blocks += [Figure(f"{name}.svg", f"{figure} ({about})."), quality_table(result, f"At the end: {about}"),
                       tolerance_table(result, f"Fractions within a tolerance [m] at the end: {about}")]


def largest_sag(values):
    """How far a curve falls below what it had reached before."""
    highest, sag = float("-inf"), 0.0
    for value in values:
        highest = max(highest, value)
        sag = max(sag, highest - value)
    return sag
