#!/usr/bin/env python3
"""stipple compare against OpenImageIO's idiff, where the two measure the same thing: over all pixels
of R, G and B."""
import re
import subprocess

import command

VIEW = ["--size", "123x77", "--cull", "back"]
NUMBER = r"([-+0-9.e]+|inf)"


class Idiff(command.CommandTest):
    def colors(self, name):
        """Its R, G and B alone; idiff takes every channel that there is."""
        subprocess.run(["oiiotool", self.path(name + ".exr"), "--ch", "R,G,B", "-d", "float", "-o",
                        self.path(name + "_rgb.exr")], check=True, capture_output=True)
        return self.path(name + "_rgb.exr")

    def theirs(self, a, b):
        run = subprocess.run(["idiff", "-fail", "0", self.colors(a), self.colors(b)],
                             capture_output=True, text=True)
        found = {}
        for name, words in [("mean_absolute", "Mean error"), ("rmse", "RMS error"),
                            ("psnr", "Peak SNR"), ("maximum", r"Max error ")]:
            found[name] = float(re.search(words + r" *= " + NUMBER, run.stdout).group(1))
        return found

    def expect_same(self, a, b):
        ours = self.done_json("compare", "--json", a + ".exr", b + ".exr")["all"]
        for name, value in self.theirs(a, b).items():
            self.assertGreater(value, 0)
            self.assertAlmostEqual(ours[name] / value, 1, 4, (name, ours[name], value))

    def test_renders(self):
        for name, more in [("truth", ["--method", "reference"]),
                           ("rough", ["--method", "deferred", "--overlap", "0.3"]),
                           ("wide", ["--method", "two-pass", "--epsilon", "0.5"])]:
            self.done("render", "ball.ply", "-o", name + ".exr", *VIEW, *more)
        self.expect_same("rough", "truth")
        self.expect_same("wide", "truth")
        self.expect_same("rough", "wide")

    def test_generated(self):
        """Pictures that stipple did not make: noise of a known spread on a ramp."""
        subprocess.run(["oiiotool", "--create", "64x48", "3", "--fill:topleft=0,0,0:"
                        "bottomright=1,0.5,2", "64x48", "-d", "float", "-o", self.path("a.exr")],
                       check=True, capture_output=True)
        subprocess.run(["oiiotool", self.path("a.exr"), "--noise:type=gaussian:mean=0.01:stddev=0.1:"
                        "seed=5", "-d", "float", "-o", self.path("b.exr")],
                       check=True, capture_output=True)
        self.expect_same("a", "b")


command.main()
