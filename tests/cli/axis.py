#!/usr/bin/env python3
"""Points and splats by --method axis: lists, merges and paths, and what is refused."""
import math
import random
import struct

import command

AXIS = ["--method", "axis", "--size", "48x40"]


def discs(count=300):
    """(x, y, z, nx, ny, nz, radius, red, green, blue) that cross at random."""
    draw = random.Random(7)
    rows = []
    for _ in range(count):
        n = [draw.gauss(0, 1) for _ in range(3)]
        length = math.sqrt(sum(c * c for c in n))
        rows.append([draw.uniform(-1, 1) for _ in range(3)] + [c / length for c in n] +
                    [0.1 + 0.2 * draw.random()] + [draw.random() for _ in range(3)])
    return rows


def ply(rows):
    names = "x y z nx ny nz radius red green blue".split()
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(rows)
    header += "".join("property float %s\n" % name for name in names) + "end_header\n"
    return header.encode() + b"".join(struct.pack("<10f", *row) for row in rows)


class Axis(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.rows = discs()
        self.write("discs.ply", ply(self.rows))

    def picture(self, *options, file="discs.ply"):
        self.done("render", file, *AXIS, *options, "-o", "a.exr")
        return self.read("a.exr")

    def psnr(self, a, b):
        self.write("one.exr", a)
        self.write("two.exr", b)
        return self.done_json("compare", "--json", "one.exr", "two.exr")["covered"]["psnr"]

    def test_merges_and_paths(self):
        merges = {}
        for merge in ("blend", "clip", "single", "sort"):
            one = self.picture("--axis-merge", merge, "--path", "compute")
            other = self.picture("--axis-merge", merge, "--path", "raster")
            if one != other:
                self.assertGreater(self.psnr(one, other), 80, merge)
            merges[merge] = one
        self.assertEqual(len(set(merges.values())), 4)
        self.assertEqual(self.picture("--path", "compute"), merges["blend"])
        truth = self.picture("--axis-merge", "reference")
        for merge, one in merges.items():
            self.assertGreater(self.psnr(one, truth), 25, merge)
        self.assertGreater(self.psnr(merges["sort"], truth), self.psnr(merges["single"], truth))

    def test_h_is_how_many_lists(self):
        plans = {h: self.done("plan", "discs.ply", *AXIS, "--axis-h", h) for h in ("0", "0.99")}
        self.assertIn("lists: blend, h 0,", plans["0"])
        drawn = {h: int(text.split(" splats drawn")[0].split()[-1]) for h, text in plans.items()}
        self.assertGreater(drawn["0"], 2 * drawn["0.99"])

    def test_no_order_of_points_or_threads(self):
        self.write("turned.ply", ply(self.rows[::-1]))
        for options in ([], ["--axis-merge", "sort"], ["--axis-merge", "reference"]):
            one = self.picture(*options)
            self.assertEqual(self.picture(*options, file="turned.ply"), one)
            self.assertEqual(self.picture(*options, "--threads", "1"), one)

    def test_fitted_ellipses(self):
        self.done("prepare", "ball.ply", "--fit", "0.01", "-o", "fit.ply", "-q")
        one = self.picture("--axis-merge", "reference", file="fit.ply")
        self.assertGreater(self.psnr(self.picture(file="fit.ply"), one), 25)

    def test_auto_takes_it_for_no_surface(self):
        self.assertNotIn("method axis", self.done("plan", "discs.ply"))
        self.assertNotIn("method axis", self.done("plan", "discs.ply", "--max-error", "0.1"))

    def test_an_environment(self):
        self.write("sky.hdr", b"#?RADIANCE\n\n-Y 4 +X 8\n" + bytes([64, 32, 128, 128]) * 32)
        self.fails(1, ["mirrors nothing", "exact"], "render", "discs.ply", *AXIS, "-o", "a.exr",
                   "--environment", "sky.hdr", "--reflectance", "0.5,0.5,0.5")
        # Without a change of index nothing is mirrored, and it may lie behind.
        behind = self.picture("--environment", "sky.hdr", "--background", "environment",
                              "--ior", "1")
        self.assertNotEqual(behind, self.picture())

    def test_what_is_refused(self):
        for word, options in (("below 1", ["--axis-h", "1"]), ("one sample", ["--samples", "4"]),
                              ("--shade", ["--shade", "flat"]), ("aovs", ["--aov", "id"]),
                              ("layers", ["--aov", "layers", "--opacity", "0.5"])):
            run = self.run_tool("render", "discs.ply", *AXIS, "-o", "a.exr", *options)
            self.assertIn(run.returncode, (1, 2), options)
            self.assertIn(word, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            self.assertNotIn("a.exr", self.listing())


command.main()
