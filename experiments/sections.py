# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""What each experiment has to say: text, tables, pictures and aims, as a section of the page."""
import math

import figures
from section import (EVERMAP, NOTHING, OCTOMAP, Column, Figure, Heading, Section, Table, along, at_end, curves, largest_sag,
                     mapper_of, names_of, number, ratio, tell_comparison)


def section_a(units, folder):
    section = Section("A: driving with a map that is out of date", [
        "Since the survey, parked vehicles have come, gone or shifted by 0.3 m, and 10 m of verge were 0.3 m higher. During "
        "the drive nothing changes for good. A map is good when it takes up what has come, drops what is gone, and keeps "
        "the road whole: a grid mapper looks along the road at a flat angle and erases it. In the paper's own drive, "
        "coverage rises to 83.5 % and OctoMap's sags."])
    for name, unit in units.items():
        title, result = unit["title"], unit["result"]
        tell_comparison(section, folder, name, unit,
                        [("COV 0.1", "COV within 0.1 m"), ("COV 0.2", "COV within 0.2 m"), ("AHD", "AHD")],
                        "The paper's figure 6: how much of the true surface the map covers, and how far the two are apart",
                        "The paper's figure 5: the road and what stands beside it, from above at the end")
        section.aim_at_least(title, "SA", 0.997, at_end(result, EVERMAP, "SA"))
        section.aim_at_least(title, "DA", 0.98, at_end(result, EVERMAP, "DA"))
        section.aim_at_most(title, "largest sag of COV 0.2 during the run", 0.001,
                            largest_sag(along(result, EVERMAP, "COV 0.2")))
        for metric, best, word in (("COV 0.1", max, "highest"), ("COV 0.2", max, "highest"), ("COV 0.5", max, "highest"),
                                   ("AHD", min, "lowest")):
            is_best = at_end(result, EVERMAP, metric) == best(at_end(result, m["name"], metric) for m in result["mappers"])
            section.aim(title, f"{metric} {word} of all", "yes" if is_best else "no", is_best)
    return section


def passages_of(result):
    """When each dynamic object was in view: what mappers show of it is null when it was not."""
    passages = []
    for name, shown in result["mappers"][0].get("shown", {}).items():
        scans = [scan for scan, fraction in zip(result["scan_numbers"], shown) if fraction is not None]
        if scans:
            passages.append({"name": name, "from": scans[0], "to": scans[-1]})
    return sorted(passages, key=lambda passage: passage["from"])


def appearance(mapper, said, name):
    """Mean fraction of an object's points that a map said to be there, and scans until it said so of any."""
    fractions = [fraction for fraction in mapper[said][name] if fraction is not None]
    return [sum(fractions) / len(fractions), next((i + 1 for i, f in enumerate(fractions) if f > 0), NOTHING)]


def passage_table(unit, passages):
    columns = [Column("map")]
    for passage in passages:
        columns += [Column(f"{passage['name']}: shown, mean", 3), Column("scans until shown"), Column("noticed, mean", 3)]
    columns += [Column(title, 4, max) for title in ("least ACC l", "ACC l, last", "COV l, first", "COV l, last")]
    rows = []
    for mapper in unit["result"]["mappers"]:
        accuracy, coverage = (along(unit["result"], mapper["name"], metric) for metric in ("ACC l", "COV l"))
        seen = [value for p in passages
                for value in (*appearance(mapper, "shown", p["name"]), appearance(mapper, "noticed", p["name"])[0])]
        rows.append([mapper["name"], *seen, min(accuracy), accuracy[-1], coverage[0], coverage[-1]])
    return Table("What the map showed as surface of what passed (fraction of its points in the scan just taken), what it "
                 f"noticed (pending leaves, too), and what it came to: {unit['title']}", columns, rows)


def section_b(units, folder):
    section = Section("B: standing still while others pass", [
        "The map is up to date, the robot stands, and others pass. A map is good when no trace of them is left and nothing of "
        "the street is lost, however often the same rays hit it. In the paper, ACC falls with each passage and comes back to "
        "almost 100 %. What never stays in one voxel for three scans is not taken for surface by evermap: there is nothing to "
        "take back. It is noticed all the same, as pending leaves, in the map file, too; since these exist from the first hit, "
        "no aim is set on when something is noticed."])
    for name, unit in units.items():
        title, result = unit["title"], unit["result"]
        passages = passages_of(result)
        tell_comparison(section, folder, name, unit, [("ACC l", "ACC within a leaf"), ("COV l", "COV within a leaf")],
                        "The paper's figure 8: the fraction of the map that is true, with passages in grey, and the fraction of "
                        "the truth that the map covers", "The street from above at the end", passages)
        last = max((passage["to"] for passage in passages), default=0)
        is_over = last < result["scan_numbers"][-1]
        when = "10 scans after the last one passed" if is_over else "at the end, traffic still passing"
        numbers = along(result, EVERMAP, "scan")
        at = next((i for i, scan in enumerate(numbers) if scan >= last + 10 * is_over), len(numbers) - 1)
        coverage = along(result, EVERMAP, "COV l")
        section.aim_at_least(title, f"ACC l, {when}", 0.999, along(result, EVERMAP, "ACC l")[at])
        section.aim_at_least(title, f"COV l as a fraction of the first, {when}", 0.999, ratio(coverage[at], coverage[0]))
        section.blocks.append(passage_table(unit, passages))
    return section


def section_c(units, folder):
    section = Section("C: a quarry at work", [
        "Heaps grow and shrink, machines have come and gone since the survey, trucks and people go about, and the robot drives "
        "around. A map is good when it follows the piles, drops what is gone, keeps the ground whole and shows no trail. Grid "
        "mappers need seconds for a scan, so that beside them scans are left out; the whole loop at 10 Hz is driven without "
        "them. Scans of the scenario that are driven: " + "; ".join(
            f"{unit['title']}: one of {unit['settings']['every']}, the first {unit['settings']['scans']}"
            for unit in units.values()) + "."])
    for name, unit in units.items():
        title, result = unit["title"], unit["result"]
        tell_comparison(section, folder, name, unit, [("COV 0.2", "COV within 0.2 m"), ("AHD", "AHD")],
                        "The paper's figure 9: how much of the true surface the map covers, and how far the two are apart",
                        "The middle of the pit from above at the end")
        section.aim_at_least(title, "SA", 0.995, at_end(result, EVERMAP, "SA"))
        section.aim_at_least(title, "DA", 0.95, at_end(result, EVERMAP, "DA"))
        if mapper_of(result, OCTOMAP):
            section.aim_at_least(title, "OctoMap's AHD over evermap's", 2,
                                 ratio(at_end(result, OCTOMAP, "AHD"), at_end(result, EVERMAP, "AHD")))
        section.aim_at_most(title, "map to pile [m]", 0.03, at_end(result, EVERMAP, "pile"))
    results = [unit["result"] for unit in units.values()]
    late = next(iter(units.values()))["settings"]["late_scans"]
    section.blocks.append(Table(
        f"Mean distance [m] of the map to the true surface of the piles, where the last {late} scans of the scenario observed "
        "them. The piles under the belts still grow in that time",
        [Column("map"), *(Column(unit["title"], 3, min) for unit in units.values())],
        [[name, *(at_end(result, name, "pile") for result in results)]
         for name in (m["name"] for m in results[0]["mappers"])]))
    return section


def section_localization(units, folder):
    first = next(iter(units.values()))
    section = Section("Localization while the world changes", [
        "The pit of experiment C and the real drive of experiment A, but no map is given any pose but the first: each scan is "
        "registered against the map, and updates it there. Registration is the same for all; grids lend it a Gaussian for each "
        "occupied voxel, made of the voxels around.",
        f"Error of the position, RMSE without alignment, {first['title']}: " + "; ".join(
            f"{m['name']}{', which nobody updates,' if m['name'] == 'static map' else ''} {m['end']['ATE']:.4f} m"
            for m in first["result"]["mappers"]) + "."])
    result = first["result"]
    errors = {m["name"]: [list(p) for p in zip(result["scan_numbers"], m["end"]["error"])] for m in result["mappers"]}
    figures.draw_panels(folder / "localization.svg", [
        {"title": "Error of the position", "x": "scan", "y": "distance [m]", "series": errors, "log_y": True},
        {"title": "AHD of the map", "x": "scan", "y": "distance [m]", "series": curves(result, "AHD")}])
    section.blocks.append(Figure("localization.svg", "The paper's figure 10: error of the position, and how far map and truth "
                                                     f"are apart, over the scans ({first['title']})."))
    metrics = {"ATE": "RMSE [m]", "worst": "largest [m]", "rotation": "rotation, RMSE [deg]", "lost": "lost",
               "tracked": "tracked", "SA": "SA", "DA": "DA", "AHD": "AHD [m]"}
    rows = [[unit["title"], m["name"], *(at_end(unit["result"], m["name"], metric) for metric in metrics)]
            for unit in units.values() for m in unit["result"]["mappers"]]
    section.blocks.append(Table(
        f"Localization in the map that is being kept, leaf {first['settings']['leaf']} m; nobody updates the static map. RMSE: "
        "of the position, without alignment (ATE). Lost: fraction of scans off by more than 1 m or 5 degrees.",
        [Column("run"), Column("map"), *(Column(title, 4) for title in metrics.values())], rows))
    for name, unit in units.items():
        if unit["settings"]["finds_poses"]:
            is_real, title, result = name.endswith("_drive"), unit["title"], unit["result"]
            section.aim_at_most(title, "RMSE [m]", 0.1 if is_real else 0.03, at_end(result, EVERMAP, "ATE"))
            if not is_real:
                section.aim_at_most(title, "rotation [deg]", 0.1, at_end(result, EVERMAP, "rotation"))
            section.aim_at_most(title, "fraction lost", 0, at_end(result, EVERMAP, "lost"))
    return section


PAPERS_RATIOS = {1.0: 1.94, 0.8: 2.14, 0.6: 2.0, 0.4: 1.73, 0.2: 0.87, 0.1: 0.50}  # table II: time over OctoMap's


def timing_of(units, leaf, start, name, metric):
    for unit in units.values():
        if unit["settings"]["leaf"] == leaf and unit["settings"]["start"] == start:
            mapper = mapper_of(unit["result"], name)
            return number(mapper[metric]) if mapper else NOTHING
    return NOTHING


def section_timing(units, folder):
    starts = ("survey", "empty")
    leaves = list(dict.fromkeys(unit["settings"]["leaf"] for unit in units.values()))
    points = {unit["result"]["points_per_scan"] for unit in units.values()}
    section = Section("Time of a scan", [
        "The pit's scans again, in turns. A grid mapper writes each voxel along each ray; evermap reads the occupied leaves that "
        "rays meet, skips what is empty by whole bricks, and keeps surface alone. How much that saves depends on where a run "
        "begins: with the map of the survey, which evermap holds in full and a grid still has to fill with what is free, or "
        "with empty maps. The lower ratio comes first."])

    def gain(leaf, start, metric):
        return ratio(timing_of(units, leaf, start, OCTOMAP, metric), timing_of(units, leaf, start, EVERMAP, metric))

    gains = []
    for leaf in leaves:
        row = [leaf]
        for metric in ("median_ms", "memory_bytes"):
            values = [gain(leaf, start, metric) for start in starts]
            row += [min(values), *values]
        gains.append(row)
    section.blocks.append(Table(
        "How many times faster evermap is than OctoMap, fed all points, and how many times smaller its map",
        [Column("leaf [m]", 1), *(Column(f"{what}, {which}", 1) for what in ("faster", "smaller")
                                  for which in ("lower of both", "from the survey", "from empty maps"))], gains))

    def panel(title, y, metric, scale, start):
        names = dict.fromkeys(m["name"] for unit in units.values() for m in unit["result"]["mappers"])
        series = {name: [[leaf, scale * timing_of(units, leaf, start, name, metric)] for leaf in leaves] for name in names}
        return {"title": title, "x": "leaf edge [m]", "y": y, "log_x": True, "log_y": True, "series": series}

    figures.draw_panels(folder / "timing.svg", [
        panel("CPU time, from the survey", "median of a scan [ms]", "median_ms", 1, "survey"),
        panel("CPU time, from empty maps", "median of a scan [ms]", "median_ms", 1, "empty"),
        panel("Memory, from the survey", "map [MB]", "memory_bytes", 1e-6, "survey")])
    section.blocks.append(Figure("timing.svg", "CPU time of a scan and the map's memory, over the leaf edge. All axes are "
                                               "logarithmic."))

    def relative(leaf, start, name, to):
        return ratio(timing_of(units, leaf, start, name, "median_ms"), timing_of(units, leaf, start, to, "median_ms"))

    section.blocks.append(Table(
        "Time relative to OctoMap, beside the paper's table II; above 1 is slower, below 1 faster. The paper's OctoMap is several "
        "times as fast as ours, most likely because it was fed filtered scans, so both comparisons are given.",
        [Column("leaf [m]", 1), Column("the paper", 2),
         *(Column(f"{what}, {which}", 4) for which in ("from the survey", "from empty maps")
           for what in ("evermap paper", "evermap default", "evermap default x OctoMap, voxel means"))],
        [[leaf, PAPERS_RATIOS.get(leaf), *(relative(leaf, start, name, to) for start in starts for name, to in (
            ("evermap paper", OCTOMAP), (EVERMAP, OCTOMAP), (EVERMAP, "OctoMap, voxel means")))] for leaf in leaves]))
    section.blocks.append(Table(
        f"CPU time of one scan, one thread, {' to '.join(f'{p:,}' for p in sorted({min(points), max(points)}))} points a scan.",
        [Column("leaf [m]", 1), Column("from"), Column("map"),
         *(Column(f"{what} [ms]", 1) for what in ("mean", "deviation", "median")), Column("map [MB]", 1), Column("scans")],
        [[unit["settings"]["leaf"], unit["settings"]["start"], m["name"], m["mean_ms"], m["deviation_ms"], m["median_ms"],
          1e-6 * m["memory_bytes"], unit["result"]["scans"]] for unit in units.values() for m in unit["result"]["mappers"]]))
    return section


WORLDS = {"drive": ("drive", ("static kept", "parked kept", "moving removed")), "redlight": ("red light", ("kept",)),
          "yard": ("yard", ("SA", "DA")), "still": ("yard, still", ("SA",)), "street": ("A street", ("SA", "DA", "AHD")),
          "passing": ("B passing", ("SA", "ACC l")), "quarry": ("C quarry", ("SA", "DA", "AHD"))}


def section_ablation(units, folder):
    section = Section("Ablation: one rule after the other", [
        "Each row adds one rule to the row before, from the paper to the default; the printed third case and "
        "what follows the default stand alone. Drive: KITTI, a map built of all scans with the trails of movers in it, then updated "
        "over the same scans. Red light: fraction kept of what the last scans, too, show within 3 cm. Yard, still: from one "
        "place."])
    for leaf in dict.fromkeys(unit["settings"]["leaf"] for unit in units.values()):
        columns, chosen = [Column("rule")], []
        for unit in units.values():
            if unit["settings"]["leaf"] == leaf:
                title, metrics = WORLDS[unit["settings"]["world"]]
                chosen += [(unit["result"], metric) for metric in metrics]
                columns += [Column(f"{title}: {m}", 3 if m == "AHD" else 4, min if m == "AHD" else max) for m in metrics]
        rows = [[rule, *(number(result[rule][metric]) for result, metric in chosen)] for rule in chosen[0][0]]
        section.blocks.append(Table(f"Leaf {leaf} m", columns, rows))
    return section


def section_robustness(units, folder):
    first = next(iter(units.values()))
    metrics = ("SA", "DA", "AA", "COV 0.2", "ACC 0.2", "AHD")
    return Section("Robust, not tuned", [
        "The same default parameters everywhere. Here a short run through the pit is repeated with other noise of the sensor, and "
        "with poses that are off: normal noise, each scan and each axis by itself, of that standard deviation. Registered: the "
        "noisy poses are taken for odometry only, and each map is given its scans where they fit it, as `evermap localize "
        "--maintain --odometry` does.",
        Table(f"The pit, leaf {first['settings']['leaf']} m, {first['result']['scans']} scans",
              [Column("what differs"), Column("map"),
               *(Column(m + " [m]" if m == "AHD" else m, 3 if m == "AHD" else 4) for m in metrics)],
              [[unit["title"], m["name"], *(at_end(unit["result"], m["name"], metric) for metric in metrics)]
               for unit in units.values() for m in unit["result"]["mappers"]])])


def percentile(values, fraction):
    return sorted(values)[int(fraction * (len(values) - 1))] if values else NOTHING


def section_arena(units, folder):
    trials, by_all = [], []
    for unit in units.values():
        for trial in unit["result"]["trials"]:
            (by_all if "mappers" in trial else trials).append(trial)
    kinds = sorted({trial["kind"] for trial in trials})

    def total(some, key):
        return sum(trial[key] for trial in some)

    def percent_tracked(some):
        return 100 * ratio(total(some, "tracked"), total(some, "observable"))

    def errors_of(some):
        return [1000 * error for trial in some for error in trial["errors"]]

    def row(name, some):
        errors = errors_of(some)
        return [name, len(some), percent_tracked(some), total(some, "wrong"), total(some, "wrong written"),
                percentile(errors, 0.5), percentile(errors, 0.95), max(errors, default=NOTHING)]

    def rival_row(name):
        some = [trial["mappers"][name] for trial in by_all]
        errors = errors_of(some)
        return [name, percent_tracked(some), total(some, "wrong"), total(by_all, "scans"), percentile(errors, 0.5),
                percentile(errors, 0.95)]

    def sorted_errors(kind):
        errors = sorted(error for trial in trials if trial["kind"] == kind for error in trial["errors"])
        return [[(i + 1) / len(errors), error] for i, error in enumerate(errors)]

    figures.draw_panels(folder / "arena.svg", [{
        "title": "Error of believed poses, sorted", "x": "fraction of the scans", "y": "error [m]", "log_y": True,
        "series": {kind: sorted_errors(kind) for kind in kinds}}])
    section = Section("The arena: localization in random worlds", [
        "Short drives through random worlds: sensors, leaves, frames, starts, odometry and changes are drawn, too. A judge that "
        "sees the true surfaces says what of a pose can be known. A scan is confidently wrong when it is believed and more than "
        "5 cm or 0.5 degrees off in what can be known. The first one or two scans of a drive only start.",
        Figure("arena.svg", "Errors in what can be known, over all believed scans, per kind of world."),
        Table(f"{len(trials)} trials", [Column("kind"), Column("trials"), Column("tracked [%]", 1), Column("confidently wrong"),
                                        Column("of these written"), Column("median [mm]", 1), Column("95 % [mm]", 1),
                                        Column("largest [mm]", 0)],
              [row(kind, [t for t in trials if t["kind"] == kind]) for kind in kinds] + [row("all", trials)])])
    if by_all:
        section.blocks.append(Table(
            f"{len(by_all)} of these trials by others, too: each scan aligned to the cloud of the map, from where odometry or the "
            "velocity before leads; what converges is believed",
            [Column("method"), Column("tracked [%]", 1), Column("confidently wrong"), Column("of scans"), Column("median [mm]", 1),
             Column("95 % [mm]", 1)],
            [rival_row(name) for name in by_all[0]["mappers"]]))
    section.aim_at_most("arena", "confidently wrong scans", 0, total(trials, "wrong"))
    section.aim_at_least("arena", "fraction tracked", 0.99, percent_tracked(trials) / 100)
    return section


def section_worlds(units, folder):
    def pairs(name):
        found = [[at_end(unit["result"], name, metric) for metric in ("DA", "SA")] for unit in units.values()]
        return [pair for pair in found if not any(math.isnan(value) for value in pair)]

    names = names_of(next(iter(units.values()))["result"])
    names = [name for name in names if pairs(name)]
    figures.draw_panels(folder / "worlds.svg", [{"title": "Each world a point", "x": "DA", "y": "SA", "scattered": True,
                                                 "series": {name: pairs(name) for name in names}}])

    def row(name):
        erased, kept = zip(*pairs(name))
        return [name, percentile(kept, 0.5), percentile(kept, 0.05), percentile(erased, 0.5), percentile(erased, 0.05)]

    section = Section("Random worlds: maintenance", [
        "The arena's worlds at given poses. SA: unchanged surface kept; DA: removed surface erased. Worlds in which nothing was "
        "removed where rays could tell are left out.",
        Figure("worlds.svg", "What each map kept and erased, world by world."),
        Table(f"{len(units)} worlds", [Column("map"), Column("SA, median", 4, max), Column("SA, worst twentieth", 4, max),
                                       Column("DA, median", 4, max), Column("DA, worst twentieth", 4, max)],
              [row(name) for name in names])])
    own = row(EVERMAP)
    for metric, aimed, reached in zip(("SA, median", "SA, worst twentieth", "DA, median", "DA, worst twentieth"),
                                      (0.997, 0.985, 0.97, 0.90), own[1:]):
        section.aim_at_least("worlds", metric, aimed, reached)
    return section


def section_year(units, folder):
    section = Section("A year: the map that is left on its own", [
        "A robot drives the same round day after day, localizes in its map without odometry, updates it, and finds it in the "
        "evening's state the next morning; only the first pose of each day is given. In the container terminal a fifth of the bays "
        "change each night. In the pit two of the 18 blocks of the walls are blasted back by 2.5 m each night, a strip of the floor "
        "is dug 0.4 m deeper, and piles and machines come and go. A robot that was lost for two seconds stands still for the day. "
        "Kept (SA): of what sessions before saw and still stands; erased "
        "(DA): of all that any session before saw and is gone; both where the day's rays could tell."])
    for name, unit in units.items():
        title, result, leaf = unit["title"], unit["result"], unit["settings"]["leaf"]
        sessions = len(result["survey left"])

        def series(metric):
            return {m["name"]: [[row["session"], row[metric]] for row in m["rows"]] for m in result["mappers"]}

        figures.draw_panels(folder / f"{name}.svg", [
            {"title": "Error of the position, RMSE", "x": "session", "y": "distance [m]", "series": series("ATE"), "log_y": True},
            {"title": "Lost", "x": "session", "y": "fraction of the scans", "series": series("lost")},
            {"title": "Kept of what still stands (SA)", "x": "session", "y": "fraction", "series": series("SA")},
            {"title": "Erased of what is gone (DA)", "x": "session", "y": "fraction", "series": series("DA")}])
        section.blocks += [Heading(title), Figure(
            f"{name}.svg", f"{title}, leaf {leaf} m: {sessions} sessions, after which {100 * result['survey left'][-1]:.0f} % of "
                           "the first survey is left around the route.")]
        last = range(-max(1, sessions // 4), 0)

        def row(name):
            ate, lost, kept, erased = (along(result, name, metric) for metric in ("ATE", "lost", "SA", "DA"))
            ends = mapper_of(result, name)["rows"][-1]
            first_lost = next((str(i + 1) for i, fraction in enumerate(lost) if fraction > 0), "never")
            return [name, ate[0], percentile([ate[i] for i in last], 0.5), max(ate), first_lost, min(kept), kept[-1], min(erased),
                    erased[-1], ends["AHD"], ends["leaves"] / result["fresh leaves"][-1], ends["cpu ms"]]

        section.blocks.append(Table(
            f"{title}: sessions 1 to {sessions}. ATE: RMSE of the position without alignment. Lost: first session with a scan off "
            "by more than 1 m or 5 degrees. Leaves: as a fraction of those of a fresh survey. CPU: of a scan, median of the last "
            "session.",
            [Column("map"), Column("ATE, first [m]", 4), Column("ATE, last quarter, median [m]", 4), Column("ATE, worst [m]", 4),
             Column("lost in session"), Column("SA, least", 4, max), Column("SA, last", 4, max), Column("DA, least", 4, max),
             Column("DA, last", 4, max), Column("AHD, last [m]", 3, min), Column("leaves", 3), Column("CPU [ms]", 1)],
            [row(m["name"]) for m in result["mappers"]]))

        own = mapper_of(result, EVERMAP)["rows"]
        static = mapper_of(result, "static map")["rows"]
        section.aim_at_least(title, "worst ATE of the static map in the last quarter [m]", 0.5, max(static[i]["ATE"] for i in last))
        section.aim_at_most(title, "ATE of the last session over that of the first", 1.5, ratio(own[-1]["ATE"], own[0]["ATE"]))
        section.aim_at_most(title, "fraction lost, worst session", 0, max(row["lost"] for row in own))
        section.aim_at_least(title, "SA of the last session", 0.995, number(own[-1]["SA"]))
        section.aim_at_least(title, "DA of the last session", 0.97, number(own[-1]["DA"]))
        section.aim_at_most(title, "leaves off those of a fresh survey", 0.05,
                            abs(own[-1]["leaves"] / result["fresh leaves"][-1] - 1))
    return section


def section_demo(units, folder):
    metrics = ("SA", "DA", "COV 0.1", "COV 0.2", "ACC 0.1", "ACC 0.2", "AHD")
    table = Table("SA: unchanged surface kept. DA: removed surface erased. COV, ACC: fraction of the true surface near the map, of "
                  "the map near the true surface [m]. AHD: distance between the two [m].",
                  [Column("leaf", 1), Column("map"), *(Column(metric, 4) for metric in metrics)],
                  [[unit["settings"]["leaf"], m["name"], *(at_end(unit["result"], m["name"], metric) for metric in metrics)]
                   for unit in units.values() for m in unit["result"]["mappers"]])
    scale, heights, colours = (folder / "legend.txt").read_text(encoding="utf-8").splitlines()
    section = Section("A yard that changed", [
        "Since the survey one box vanished, one appeared, one moved by 0.25 m, and a heap grew. A robot drives through. What each "
        "map became:", table,
        Figure("change.png", f"What evermap changed in its map. {colours.partition(': ')[2].capitalize()} {scale}"),
        Figure("before.png", f"The map before: {heights.partition(': ')[2]}"),
        Figure("after.png", f"The map after: {heights.partition(': ')[2]}")], printed=[table])
    for name, unit in units.items():
        tell_comparison(section, folder, name, unit, [("COV 0.2", "COV within 0.2 m"), ("AHD", "AHD")],
                        "How much of the true surface the map covers, and how far the two are apart",
                        "The yard from above at the end")
    return section


TELL = {"demo": section_demo, "a": section_a, "b": section_b, "c": section_c, "localization": section_localization,
        "timing": section_timing, "ablation": section_ablation, "robustness": section_robustness, "arena": section_arena,
        "worlds": section_worlds, "year": section_year}


def tell(name, result, folder):
    section = TELL[name](result["units"], folder)
    section.blocks += result["left_out"]
    section.command, section.is_quick = result["command"], result["quick"]
    return section


def overview(told):
    section = Section("At a glance", [
        "A robot has a map from a survey. The world changes, and each mapper updates the same map with the same scans. OctoMap, "
        "the usual grid mapper, takes each ray as proof that all it crosses is free. Rays that graze the ground erase it: look "
        "for orange in the pictures. A map that nobody updates keeps what is gone: look for blue. evermap asks of each ray "
        "whether it truly contradicts the surface in a leaf."])
    glances = [row for s in told for row in s.glances]
    aims = [row for s in told if not s.is_quick for row in s.aims]
    if glances:
        section.blocks.append(Table(
            "SA: fraction of the unchanged surface that the map kept. DA: fraction of the removed surface that it erased. AHD: how "
            "far map and truth are apart, the larger of the two mean distances. At the end of each run.",
            [Column("data"), *(Column(f"{metric}, {name}", 3) for metric in ("SA", "DA", "AHD [m]")
                               for name in ("OctoMap", "evermap"))], glances))
    if aims:
        section.blocks.append(Table("What evermap's default is meant to reach, and what it reached here",
                                    [Column("data"), Column("aim"), Column("reached"), Column("met")], aims))
    quick = [s.title for s in told if s.is_quick]
    if quick:
        section.blocks.append(f"Quick run: aims are not judged ({'; '.join(quick)}). Few scans were driven, with one leaf size; "
                              "the figures of a full run differ.")
    return section


def method(results):
    """How it was measured, and on what."""
    units = [unit for result in results for unit in result["units"].values()]

    def values(kind, key):
        return ", ".join(f"{v:g}" for v in sorted({unit[kind][key] for unit in units if key in unit[kind]}))

    facts = dict.fromkeys((name, value) for result in results for name, value in result["machine"].items())
    return Section("How it was measured", [
        "Simulated truth is exact: the surface at the moment of the measurement, without what moves, sampled each "
        f"{values('settings', 'truth_spacing')} m; distances from the map to it are exact. A surface counts as observed where "
        "some ray of the run ended in its voxel of 0.2 m. COV and the distance from truth to map are taken over the observed "
        "truth; ACC and the distance from map to truth over all points of the map in the measured area (of more than 250,000, "
        "each so many one), which are right where any true surface is. Uncropped: over the whole truth.",
        "SA and DA are taken on points that at least 4 rays crossed and left more than 1.5 leaves behind. A point is kept when "
        "its leaf is occupied and it lies in the leaf's 99 % ellipsoid, widened by how well the point is known "
        f"({values('result', 'position_sigma_m')} m); for a grid, when its voxel is occupied. One point per leaf stands for the "
        "map: the Gaussian's mean, or the voxel's centre.",
        "Every mapper has its default parameters in all experiments. Real truth: what the drive's scans show of what does not "
        "move, each 0.05 m; COV, SA and DA on voxels of 0.1 m that at least 3 scans hit and that no more scans saw through than "
        "hit.",
        "Each section ends with the command that computes it anew, run from the source root after script/setup and a build; DIR is "
        "a folder for results, DATA the one with the real drives. experiments/report.py DIR draws this page.",
        Table("Machine and versions", [Column(""), Column("")], [list(fact) for fact in facts])])
