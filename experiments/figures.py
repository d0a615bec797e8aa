# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Plots and pictures of experiments' results."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

# Okabe and Ito's palette, which holds for every common colour blindness; lines differ in their dashes, too.
STYLES = {
    "static map": ("#000000", (0, (1, 1.5)), "."),
    "OctoMap": ("#D55E00", "-", "o"),
    "OctoMap, voxel means": ("#E69F00", "--", "v"),
    "UFOMap": ("#CC79A7", "-.", "s"),
    "Bonxai": ("#009E73", ":", "P"),
    "evermap paper": ("#56B4E9", "--", "^"),
    "evermap default": ("#0072B2", "-", "D"),
}
OTHERS = [("#0072B2", "-", "o"), ("#D55E00", "--", "s"), ("#009E73", "-.", "^"), ("#CC79A7", ":", "D"), ("#E69F00", "-", "v"),
          ("#56B4E9", "--", "."), ("#000000", "-", "o"), ("#0072B2", ":", "s"), ("#D55E00", "-", "^"), ("#009E73", "--", "D"),
          ("#CC79A7", "-", "v")]
# What a character of a view from above stands for.
CELLS = [(".", "#FFFFFF", None), ("k", "#C4CAD0", "kept"), ("h", "#D55E00", "hole: missing in the map"),
         ("g", "#0072B2", "ghost: not in the world")]

plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.color": "#E3E6E9", "axes.axisbelow": True,
                     "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "evermap"})


def save(figure, path):
    """The same results give the same bytes."""
    options = {"metadata": {"Date": None}} if path.suffix == ".svg" else {"dpi": 150}
    figure.savefig(path, bbox_inches="tight", **options)
    plt.close(figure)


def style(name, index):
    return STYLES.get(name, OTHERS[index % len(OTHERS)])


def draw_lines(axes, panel):
    for index, (name, points) in enumerate(panel["series"].items()):
        colour, dashes, marker = style(name, index)
        x = [p[0] for p in points]
        y = [np.nan if p[1] is None else p[1] for p in points]
        scattered = panel.get("scattered")
        axes.plot(x, y, label=name, color=colour, linestyle="none" if scattered else dashes, linewidth=1.4,
                  marker=marker if scattered or len(points) <= 25 else None, markersize=3.5)
    for shaded in panel.get("shaded", []):
        axes.axvspan(shaded["from"], max(shaded["to"], shaded["from"] + 1), color="#D9DDE1", zorder=0, linewidth=0)
        axes.annotate(shaded["name"], ((shaded["from"] + shaded["to"]) / 2, 1.01), ha="center", fontsize=7,
                      xycoords=("data", "axes fraction"))
    if panel.get("log_x"):
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
        ticks = sorted({p[0] for points in panel["series"].values() for p in points})
        axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    if panel.get("log_y") and any(y is not None and y > 0 for points in panel["series"].values() for _, y in points):
        axes.set_yscale("log")
        low, high = axes.get_ylim()
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 300 * low else (1,)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())


def draw_bars(axes, panel):
    width = 0.8 / len(panel["series"])
    for index, (name, values) in enumerate(panel["series"].items()):
        places = np.arange(len(values)) + (index - (len(panel["series"]) - 1) / 2) * width
        axes.bar(places, values, width, label=name, color=style(name, index)[0])
    axes.set_xticks(range(len(panel["groups"])), panel["groups"], rotation=20, ha="right")
    axes.grid(False, axis="x")


def draw_panels(path, panels):
    """Panels side by side. A panel: title, x, y, series {name: [[x, y], ...]}, or bars: groups and values."""
    figure, axes = plt.subplots(1, len(panels), figsize=(0.6 + 3.7 * len(panels), 3.3), squeeze=False,
                                layout="constrained")
    legends = {}
    for axis, panel in zip(axes[0], panels):
        (draw_bars if "groups" in panel else draw_lines)(axis, panel)
        axis.set_title(panel["title"], fontsize=10, pad=16 if panel.get("shaded") else 6)
        axis.set_xlabel(panel.get("x", ""))
        axis.set_ylabel(panel["y"])
        if panel.get("from_zero"):
            axis.set_ylim(0, 1.05 * axis.get_ylim()[1])
        legends |= {label: handle for handle, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(legends.values(), legends.keys(), loc="upper center", bbox_to_anchor=(0.5, 0), frameon=False,
                  ncols=min(len(legends), 2 * len(panels)))
    save(figure, path)


def draw_views(path, result):
    """The maps from above, side by side, north up."""
    mappers = result["mappers"]
    code = {character: index for index, (character, _, _) in enumerate(CELLS)}
    edge = result["view_cell_m"]
    pictures = [np.array([[code[c] for c in row] for row in mapper["view"]]) for mapper in mappers]
    rows, columns = pictures[0].shape
    across = 1 if columns > 3 * rows else 2
    down = -(-len(pictures) // across)
    width = 9 / across
    figure, axes = plt.subplots(down, across, figsize=(9, 0.5 + down * (width * rows / columns + 0.3)),
                                squeeze=False, sharex=True, sharey=True, layout="constrained")
    for axis in axes.flat[len(pictures):]:
        axis.set_visible(False)
    for axis, picture, mapper in zip(axes.flat, pictures, mappers):
        axis.imshow(picture, cmap=ListedColormap([colour for _, colour, _ in CELLS]), vmin=0, vmax=len(CELLS) - 1,
                    interpolation="nearest", extent=(0, columns * edge, 0, rows * edge))
        axis.set_title(mapper["name"], fontsize=9, loc="left")
        axis.grid(False)
    figure.supxlabel("east [m]", fontsize=9)
    figure.supylabel("north [m]", fontsize=9)
    figure.legend([Patch(color=colour) for _, colour, text in CELLS if text], [text for *_, text in CELLS if text],
                  loc="upper center", bbox_to_anchor=(0.5, 0), ncols=3, frameon=False)
    save(figure, path)
