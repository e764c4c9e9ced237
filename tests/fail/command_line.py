#!/usr/bin/env python3
"""A wrong command line: one line that names the option and what is allowed; status 2; nothing is
read or written, not even a file that is missing."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

OUT = ["render", "ball.ply", "-o", "out.exr"]
# Option, wrong values, a word of what is allowed.
WRONG_VALUES = [
    ("--size", ["12", "0x5", "5x0", "axb", "1x2x3", "-1x2", "65537x1", " 1x1", "1x1 ", ""], "WIDTH"),
    ("--view", ["up", "1", "1,2,3", "nan,0", "400,0", "0,91", ""], "front"),
    ("--fov", ["0", "-1", "176", "x", "1e400", "inf"], "degrees"),
    ("--samples", ["0", "-1", "1.5", "4097", "99999999999999999999"], "whole number"),
    ("--method", ["fast", "Exact", "exact ", ""], "two-pass"),
    ("--path", ["cpu"], "compute"),
    ("--payload", ["8"], "packed"),
    ("--voronoi", ["on"], "slab"),
    ("--kernel", ["box"], "gauss"),
    ("--cull", ["front"], "back"),
    ("--up", ["-z", "Y"], "-y"),
    ("--transfer", ["gamma"], "linear"),
    ("--two-sided", ["yes"], "off"),
    ("--compression", ["dwaa"], "piz"),
    ("--overlap", ["0", "1.01", "-0.5", "nan"], "above 0"),
    ("--groups", ["0", "65"], "1 to 64"),
    ("--relax", ["all", "none,opposed", "coplanar,"], "coplanar"),
    ("--epsilon", ["0", "-1", "nan", "inf", "0x1"], "above 0"),
    ("--min-splat", ["-1", "65"], "0 to 64"),
    ("--opacity", ["-0.1", "1.01", "nan", "half"], "0 to 1"),
    ("--transparency", ["slow", "Exact"], "nearest"),
    ("--peel-layers", ["0", "1001", "2.5"], "1 to 1000"),
    ("--clip-box", ["1,2,3", "0,0,0,1,1,-1", "0,0,0,1,1,1,1"], "six numbers"),
    ("--background", ["1,1", "1,1,1,2", "red"], "none"),
    ("--aov", ["depth", "albedo,,P"], "albedo"),
    ("--exposure", ["bright", "65"], "-64"),
    ("--frames", ["3:1", "1", "a:b", "-1:2"], "A:B"),
    ("--tile-memory", ["0", "1T", "K", "-5"], "whole number"),
    ("--mask-feature", ["geometry", ""], "int64-atomics"),
    ("--threads", ["0", "257"], "1 to 256"),
    ("--repeat", ["-1", "x"], "whole number"),
    ("--output", ["out.png", ".exr", "exr"], ".exr"),
    ("--preview", ["out.jpg"], ".png"),
]
# Command line, words of the line.
WRONG_LINES = [
    (["rendr", "ball.ply"], ["rendr", "render"]),
    (["render"], ["usage: stipple render"]),
    (["render", "ball.ply"], ["-o OUT.exr"]),
    (["render", "ball.ply", "more.ply", "-o", "out.exr"], ["more.ply"]),
    (["render", "ball.ply", "-o"], ["--output"]),
    ([*OUT, "--half=1"], ["--half", "no value"]),
    ([*OUT, "--layers"], ["--layers"]),
    ([*OUT, "--s", "1"], ["--size", "--samples", "--stats"]),
    ([*OUT, "-z"], ["-z"]),
    ([*OUT, "--frames", "0:1"], ["--camera"]),
    ([*OUT, "--frames", "0:1", "--camera", "c.json"], ["%d", "--output"]),
    (["render", "ball.ply", "-o", "%s.exr", "--frames", "0:1", "--camera", "c.json"], ["%d"]),
    (["render", "ball.ply", "-o", "%d%d.exr", "--frames", "0:1", "--camera", "c.json"], ["%d"]),
    ([*OUT, "--camera", "c.json", "--view", "iso"], ["--camera", "--view"]),
    ([*OUT, "--stats", "out.exr"], ["out.exr", "two outputs"]),
    (["plan"], ["usage: stipple plan"]),
    (["plan", "ball.ply", "--device", "x"], ["--device"]),
    (["prepare", "ball.ply"], ["-o OUT.ply"]),
    (["prepare", "ball.ply", "-o", "out.ply", "--overlap", "0.5"], ["--group"]),
    (["compare", "a.exr"], ["usage: stipple compare"]),
    (["compare", "a.exr", "b.exr", "--fail-under-psnr", "x"], ["--fail-under-psnr", "decibels"]),
    (["devices", "x"], ["'x'"]),
    (["info"], ["usage: stipple info"]),
]


class CommandLine(command.CommandTest):
    def test_wrong_values(self):
        for option, values, allowed in WRONG_VALUES:
            for value in values:
                with self.subTest(option=option, value=value):
                    self.fails(2, [option, allowed, "try 'stipple render --help'"], "render",
                               "ball.ply", *([] if option == "--output" else ["-o", "out.exr"]),
                               f"{option}={value}")

    def test_wrong_lines(self):
        for line, words in WRONG_LINES:
            with self.subTest(line=line):
                self.fails(2, [*words, "try 'stipple"], *line)

    def test_nothing_is_read(self):
        self.fails(2, ["--samples"], "render", "missing.ply", "-o", "out.exr", "--samples", "0")

    def test_a_field_that_is_not_there(self):
        self.fails(2, ["ball.ply", "warmth"], *OUT, "--color-by", "warmth", "--method",
                   "reference")

    def test_frames_beyond_the_path(self):
        self.done(*OUT, "--method", "reference", "--size", "8x8", "--write-camera", "c.json")
        self.fails(2, ["--frames", "c.json", "1 camera"], "render", "ball.ply", "-o",
                   "f.%d.exr", "--camera", "c.json", "--frames", "0:1", "--method", "reference")

    def test_no_arguments(self):
        run = self.run_tool()
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        self.assertIn("usage: stipple COMMAND", run.stderr)


command.main()
