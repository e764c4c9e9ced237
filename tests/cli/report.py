#!/usr/bin/env python3
"""stipple report on a small ball: the files are whole, agree with each other, and their errors are
those that render and compare find; and how it refuses."""
import csv
import os
import re
import shlex
import shutil
import struct
import tempfile
import xml.etree.ElementTree as xml

import command

ROUNDS = "2"
SHARED = ["--size", "96x64", "--cull", "back", "--min-splat", "0"]


class Report(command.CommandTest):
    def rows(self):
        with open(self.path("out/report.csv"), newline="", encoding="ascii") as file:
            return list(csv.DictReader(file))

    plain = None  # the folder of the report without further options: made once, then copied

    def make(self, *more):
        if not more and Report.plain:
            shutil.copytree(Report.plain, self.path("out"))
            return self.rows()
        self.done("report", "ball.ply", "-o", "out", "--quick", "--rounds", ROUNDS, *SHARED, *more)
        if not more:
            Report.plain = tempfile.mkdtemp(prefix="stipple-report-")
            self.addClassCleanup(shutil.rmtree, Report.plain, ignore_errors=True)
            shutil.copytree(self.path("out"), Report.plain, dirs_exist_ok=True)
        return self.rows()

    def compared(self, row):
        """The error of a row's configuration, by the other commands."""
        options = ["--method", row["method"], "--path", row["path"]]
        for name, column in [("--payload", "payload"), ("--voronoi", "voronoi"),
                             ("--overlap", "overlap_asked")]:
            if row[column]:
                options += [name, row[column]]
        self.done("render", "ball.ply", "-o", "a.exr", *SHARED, *options)
        self.done("render", "ball.ply", "-o", "b.exr", *SHARED, "--method", "reference")
        return self.done_json("compare", "--json", "a.exr", "b.exr", "--epsilon", row["epsilon"])

    def test_files(self):
        rows = self.make()
        front = [row for row in rows if row["front"] == "1"]
        names = sorted(os.listdir(self.path("out")))
        pictures = [f"error_{i + 1}.png" for i in range(len(front))]
        self.assertEqual(names, sorted(pictures + ["auto.csv", "report.csv", "report.md",
                                                   "report.svg", "samples.csv"]))
        for name in pictures:
            head = self.read("out/" + name)[:24]
            self.assertEqual(struct.unpack(">II", head[16:])[0], 96)
        self.assertEqual(xml.fromstring(self.read("out/report.svg")).tag,
                         "{http://www.w3.org/2000/svg}svg")
        text = self.read("out/report.md").decode()
        for name in re.findall(r"\]\((\S+)\)", text):
            self.assertIn(name, names)
        self.assertIn("stipple report", text)
        self.assertNotIn(self.folder, text)

    def test_its_command_is_for_a_shell(self):
        name = "the ball's $5 & <more>.ply"
        shutil.copy(self.path("ball.ply"), self.path(name))
        words = ["report", "-o", "two words", "--quick", "--rounds", "1", "--size", "24x16", "-q", name]
        self.done(*words)
        text = self.read("two words/report.md").decode()
        command = re.search(r"^    (stipple report .*)$", text, re.M).group(1)
        self.assertEqual(shlex.split(command)[1:], words)
        title = xml.fromstring(self.read("two words/report.svg"))
        self.assertIn(name, "".join(title.itertext()))

    def test_rows(self):
        rows = self.make()
        self.assertEqual({row["method"] for row in rows},
                         {"exact", "two-pass", "deferred", "pyramid", "reference"})
        for row in rows:
            times = [float(row["ms_" + k]) for k in
                     ["min", "quartile1", "median", "quartile3", "max"]]
            self.assertEqual(times, sorted(times))
            self.assertGreater(times[0], 0)
            if row["method"] == "reference":
                self.assertEqual(row["frames"], "1")
            elif row["method"] == "two-pass":  # the baseline has its turn in every round
                self.assertEqual(row["frames"], "6")
            else:
                self.assertIn(row["frames"], ["3", "6"])
            self.assertLess(float(row["mean_absolute"]), 0.1)
            self.assertEqual(bool(row["groups"]), row["method"] == "deferred")
        for method, bound in [("exact", 1e-3), ("two-pass", 1e-4), ("reference", 0)]:
            errors = [float(r["mean_absolute"]) for r in rows if r["method"] == method]
            self.assertLessEqual(max(errors), bound)

    def test_errors_are_those_of_compare(self):
        rows = self.make()
        for wanted in [("exact", "compute"), ("deferred", "compute"), ("two-pass", "raster")]:
            row = next(r for r in rows if (r["method"], r["path"]) == wanted)
            other = self.compared(row)
            for name in ["mean_absolute", "rmse", "p999", "over_1_255"]:
                self.assertAlmostEqual(float(row[name]), other["covered"][name], 9, (wanted, name))
            for name in ["coverage_differs", "depth_mean", "normal_mean", "flip"]:
                self.assertAlmostEqual(float(row[name]), other[name], 6, (wanted, name))

    def test_what_auto_takes(self):
        rows = self.make()
        with open(self.path("out/auto.csv"), newline="", encoding="ascii") as file:
            picks = list(csv.DictReader(file))
        self.assertEqual([float(pick["bound"]) for pick in picks], [1e-2, 3e-3, 1e-3, 1e-4, 1e-5])
        self.assertIn("## What auto takes", self.read("out/report.md").decode())
        for pick in picks:
            within = [row for row in rows if row["method"] != "reference" and
                      float(row["mean_absolute"]) <= float(pick["bound"])]
            fastest = min(within, key=lambda row: float(row["ms_median"]))
            self.assertEqual((pick["best_method"], pick["best_ms"]),
                             (fastest["method"], fastest["ms_median"]))
            taken = [row for row in rows if row["ms_median"] == pick["ms"]]
            self.assertEqual([row["method"] for row in taken], [pick["method"]])
            self.assertLessEqual(float(pick["error"]), float(pick["predicted_error"]))
            self.assertLessEqual(float(pick["predicted_error"]), float(pick["bound"]))

    def test_samples_converge(self):
        self.make()
        with open(self.path("out/samples.csv"), newline="", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["samples"] for row in rows], ["1", "4", "16"])
        errors = [float(row["rmse"]) for row in rows]
        self.assertLess(errors[1], errors[0])
        # Stratified: between 1 / N and 1 / sqrt(N), the reference's own noise beside it.
        self.assertLess(errors[2], 0.4 * errors[0])
        self.assertIn("## Samples", self.read("out/report.md").decode())

    def test_transparent_scenes(self):
        rows = self.make("--opacity", "0.5")
        self.assertEqual(rows[-1]["method"], "reference")
        self.assertEqual({row["transparency"] for row in rows[:-1]},
                         {"exact", "fast", "nearest", "peel"})
        peeled = {int(row["peel_layers"]): float(row["mean_absolute"]) for row in rows
                  if (row["transparency"], row["path"]) == ("peel", "raster")}
        self.assertEqual(set(peeled), {2, 8})
        self.assertLess(peeled[8], 1e-3)
        exact = next(row for row in rows if row["transparency"] == "exact")
        for name, column in [("a.exr", "exact"), ("b.exr", "reference")]:
            self.done("render", "ball.ply", "-o", name, *SHARED, "--opacity", "0.5",
                      "--transparency", column)
        other = self.done_json("compare", "--json", "a.exr", "b.exr", "--epsilon",
                               exact["epsilon"])
        self.assertAlmostEqual(float(exact["mean_absolute"]), other["covered"]["mean_absolute"], 6)
        self.assertLess(float(exact["mean_absolute"]), 1e-4)

    def test_volumes(self):
        side = 12
        self.write("ball.raw", bytes(200 if sum((c - 5.5) ** 2 for c in
                                                (i % side, i // side % side, i // side ** 2)) < 20
                                     else 0 for i in range(side ** 3)))
        volume = ["--volume-dims", "12,12,12"]
        self.done("report", "ball.raw", "-o", "out", "--quick", "--rounds", "1", "--size", "48x48",
                  *volume)
        rows = self.rows()
        self.assertEqual({row["axis_merge"] for row in rows[:-1]},
                         {"single", "clip", "sort", "blend"})
        self.assertEqual({row["path"] for row in rows[:-1]}, {"compute", "raster"})
        for row in rows[:-1]:
            self.done("render", "ball.raw", *volume, "--size", "48x48", "-o", "a.exr",
                      "--axis-merge", row["axis_merge"], "--path", row["path"])
            self.done("render", "ball.raw", *volume, "--size", "48x48", "-o", "b.exr",
                      "--method", "reference")
            other = self.done_json("compare", "--json", "a.exr", "b.exr", "--epsilon",
                                   row["epsilon"])
            self.assertAlmostEqual(float(row["mean_absolute"]), other["covered"]["mean_absolute"],
                                   7, row)
        text = self.read("out/report.md").decode()
        self.assertIn("kernels, 48 x 48 pixels", text)
        self.assertIn("The baseline is single", text)

    def test_masked_features_are_left_out(self):
        rows = self.make("--mask-feature", "int64-atomics")
        self.assertFalse([r for r in rows if (r["method"], r["path"]) == ("deferred", "compute")])
        self.assertTrue([r for r in rows if r["method"] == "deferred"])
        self.assertIn("shaderBufferInt64Atomics", self.read("out/report.md").decode())

    def test_columns_are_documented(self):
        documents = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs")
        with open(os.path.join(documents, "report.md"), encoding="utf-8") as file:
            text = file.read()
        for name in self.make()[0]:
            self.assertIn(f"`{name}`", text)

    def test_refusals(self):
        self.fails(2, ["-o DIR"], "report", "ball.ply")
        self.fails(2, ["--rounds", "1 to 1000"], "report", "ball.ply", "-o", "out", "--rounds", "0")
        self.fails(2, ["--method"], "report", "ball.ply", "-o", "out", "--method", "exact")
        self.fails(1, ["ball.ply", "Not a directory"], "report", "ball.ply", "-o", "ball.ply")
        self.fails(1, ["no/out"], "report", "ball.ply", "-o", "no/out")
        self.fails(3, ["none.ply"], "report", "none.ply", "-o", "out")


command.main()
