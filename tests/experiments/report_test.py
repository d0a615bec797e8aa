#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""report_test.py PROGRAM: that a page and pictures come out of results, and clear errors out of what is none."""
import contextlib
import io
import json
import math
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EXPERIMENTS = Path(__file__).resolve().parents[2] / "experiments"
sys.path.insert(0, str(EXPERIMENTS))
import report  # noqa: E402
import section  # noqa: E402
import sections  # noqa: E402

PROGRAM = sys.argv.pop() if len(sys.argv) > 1 else None


def mapper(name, kept):
    row = {f"{kind} {tolerance}": kept for kind in ("COV", "ACC") for tolerance in section.TOLERANCES}
    row |= {"truth to map": 0.1, "map to truth": 0.2, "AHD": 0.2}
    return {"name": name, "rows": [row | {"scan": scan} for scan in (0, 9, 19)], "view": ["k.g", "h.."],
            "shown": {"van": [None, 0.0, 0.5]}, "noticed": {"van": [None, 1.0, 1.0]},
            "end": {"SA": kept, "DA": None, "AA": None, "uncropped COV 0.2": 0.5, "uncropped AHD": 0.5}}


def experiment(name, unit, quick=False):
    result = {"scans": 3, "scan_numbers": [0, 9, 19], "view_cell_m": 0.3, "position_sigma_m": 0.02,
              "mappers": [mapper("static map", 1.0), mapper("OctoMap", 0.5), mapper("evermap default", 0.99)]}
    settings = {"leaf": 0.2, "truth_spacing": 0.17}
    return {"experiment": name, "quick": quick, "command": f"compute {name} <again>", "machine": {"processor": "a"},
            "left_out": ["a part is left out"], "units": {unit: {"title": "A & B", "settings": settings, "result": result}}}


class ReportTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, content):
        text = content if isinstance(content, str) else json.dumps(content)
        (self.folder / name).write_text(text, encoding="utf-8")

    def run_report(self, *arguments):
        """Exit code, standard output and standard error."""
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
            code = report.main([str(argument) for argument in arguments])
        return code, out.getvalue(), err.getvalue()

    def expect_error(self, name, part):
        code, _, errors = self.run_report(self.folder)
        self.assertEqual(code, 1)
        self.assertEqual(errors.count("\n"), 1, errors)
        self.assertIn(str(self.folder / name), errors)
        self.assertIn(part, errors)
        self.assertFalse((self.folder / "index.html").exists())

    def test_a_year_is_told_by_sessions(self):
        year = experiment("year", "year_pit")
        result = year["units"]["year_pit"]["result"]
        result |= {"survey left": [0.9, 0.5, 0.1], "fresh leaves": [100, 100, 100]}
        for m in result["mappers"]:
            m["rows"] = [{"session": i, "ATE": 0.001 * i, "lost": 0.0, "SA": 0.99, "DA": None, "AHD": 0.1, "leaves": 104,
                          "cpu ms": 5.0} for i in (1, 2, 3)]
        self.write("year.json", year)
        code, printed, errors = self.run_report(self.folder)
        self.assertEqual(code, 0, errors)
        self.assertRegex(printed, "evermap default +0.0010 +0.0030 +0.0030 +never")
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        self.assertTrue(re.search('that of the first at most 1.5</td>\\s*<td class="">3.0000</td>\\s*<td class="">NO<', page))
        self.assertGreater((self.folder / "year_pit.svg").stat().st_size, 1000)

    def test_pictures_page_and_text_come_out(self):
        self.write("a.json", experiment("a", "a_drive_0.2"))
        self.write("b.json", experiment("b", "b_passing_0.2"))
        text = self.folder / "text.md"
        text.write_text("By hand.\n" + report.MARK + "old", encoding="utf-8")
        code, printed, errors = self.run_report(self.folder, "--markdown", text)
        self.assertEqual(code, 0, errors)
        self.assertRegex(printed, "evermap default +0.9900")
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        shown = re.sub('src="data:[^"]*"', "", page)
        for part in ("<h3>A &amp; B</h3>", "compute a &lt;again&gt;", "a part is left out", "UFOMap (not installed)",
                     "SA at least 0.997", "<td class=\"number best\">1.0000</td>", "data:image/svg+xml;base64,"):
            self.assertTrue(part in page, part)
        self.assertNotIn("nan", shown)
        for name in ("a_drive_0.2.svg", "a_drive_0.2_views.png", "b_passing_0.2.svg"):
            self.assertGreater((self.folder / name).stat().st_size, 1000, name)
        told = text.read_text(encoding="utf-8")
        self.assertTrue(told.startswith("By hand.\n" + report.MARK))
        self.assertIn("](text/b_passing_0.2_views.png)", told)
        self.assertNotIn("a_drive_0.2_views", told)  # not ours to spread
        self.assertEqual(sorted(p.name for p in (self.folder / "text").iterdir()),
                         ["a_drive_0.2.svg", "b_passing_0.2.svg", "b_passing_0.2_views.png"])

    def test_the_same_results_give_the_same_bytes(self):
        self.write("a.json", experiment("a", "a_street_0.2"))
        pages = []
        for _ in range(2):
            self.run_report(self.folder)
            pages.append((self.folder / "index.html").read_bytes())
        self.assertEqual(*pages)

    def test_a_quick_run_is_not_judged(self):
        for quick in (False, True):
            told = sections.tell("a", experiment("a", "a_street_0.2", quick), self.folder)
            blocks = sections.overview([told]).blocks
            judged = [b for b in blocks if isinstance(b, section.Table) and "meant to reach" in b.caption]
            self.assertEqual(len(judged), 0 if quick else 1)
            self.assertEqual(any("aims are not judged" in b for b in blocks if isinstance(b, str)), quick)

    def test_what_is_no_result_is_one_clear_error(self):
        self.expect_error("", "no results")
        self.write("a.json", "{ broken")
        self.expect_error("a.json", "no valid JSON")
        self.write("a.json", {"units": {"a_street_0.2": {"title": "x"}}})
        self.expect_error("a.json", "'result'")

    def test_the_best_is_marked_as_it_is_written(self):
        table = section.Table("", [section.Column("map"), section.Column("AHD [m]", 2, min)],
                              [["one", 0.481], ["two", 0.479], ["three", 0.5], ["four", math.nan]])
        rows = report.html_table(table)["rows"]
        self.assertEqual([row[1] for row in rows],
                         [("0.48", "number best"), ("0.48", "number best"), ("0.50", "number"), ("-", "number")])

    def test_a_table_for_the_terminal(self):
        table = section.Table("Caption", [section.Column("map"), section.Column("SA", 2)], [["a", 0.123], ["bcde", None]])
        self.assertEqual(report.aligned(table), "Caption\nmap     SA  \na     0.12  \nbcde     -  \n")

    def test_sags(self):
        self.assertEqual(section.largest_sag([0.5, 0.6, 0.7]), 0)
        self.assertAlmostEqual(section.largest_sag([0.5, 0.7, 0.6, 0.65, 0.8, 0.78]), 0.1)

    def test_benchmarks_are_plotted(self):
        bars = {"title": "Parts", "y": "[ms]", "groups": ["a", "b"], "series": {"leaf 1 m": [1, 2], "leaf 2 m": [3, 4]}}
        lines = {"title": "Growth", "x": "leaf [m]", "y": "[ms]", "log_x": True, "series": {"one thread": [[1, 2], [2, 3]]}}
        self.write("growth.json", {"figures": {"profile": [bars], "growth": [lines, lines]}})
        self.assertEqual(self.run_report(self.folder / "growth.json")[0], 0)
        self.assertTrue((self.folder / "profile.svg").exists() and (self.folder / "growth.svg").exists())

    @unittest.skipUnless(PROGRAM, "no program is named")
    def test_the_programs_results_are_understood(self):
        subprocess.run([PROGRAM, "timing", "--quick", "--leaf", "2", "-o", self.folder], capture_output=True, check=True)
        done = subprocess.run([EXPERIMENTS / "report.py", self.folder], capture_output=True, text=True, check=True)
        self.assertIn("How many times faster", done.stdout)
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        self.assertTrue("evermap_experiments timing -o DIR --quick --seed 1 --leaf 2" in page)


if __name__ == "__main__":
    unittest.main()
