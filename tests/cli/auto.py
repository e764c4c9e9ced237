#!/usr/bin/env python3
"""--max-error: what is decided, what it then costs in error, and the cache of calibrations."""
import json
import os
import re

import command

VIEW = ["--size", "128x128", "--min-splat", "0", "--cull", "back"]


def key(profile, version):
    """The cache's name for a device and the kinds of prices: FNV-1a over the strings with their ends."""
    value = 0xcbf29ce484222325
    kinds = [name for name in profile["calibration"] if name != "measured"]
    names = [profile["device"], profile["driver"], version, *kinds]
    for byte in b"".join(text.encode() + b"\0" for text in names):
        value = (value ^ byte) * 0x100000001b3 & (1 << 64) - 1
    return "calibration-%016x.json" % value


class Auto(command.CommandTest):
    def cache_path(self):
        profile = self.done_json("devices", "--json")
        version = self.done("--version").split()[1]
        return profile, version, os.path.join(self.cache, "stipple", key(profile, version))

    def fill_cache(self):
        """As if the device had been calibrated."""
        profile, version, path = self.cache_path()
        profile["version"] = version
        profile["calibration"]["measured"] = True
        for name in ["api_version", "usable", "lacks"]:
            del profile[name]
        os.makedirs(os.path.dirname(path))
        with open(path, "w", encoding="ascii") as file:
            json.dump(profile, file)
        return path

    def why(self, *arguments):
        text = self.done("plan", "ball.ply", *VIEW, *arguments)
        self.assertIn("\nconsidered (predicted, the cheapest first):\n", text)
        return next(line for line in text.splitlines() if line.startswith("why: "))

    def test_plan_says_why(self):
        for bound in ["1e-4", "6e-6"]:
            why = self.why("--max-error", bound)
            self.assertRegex(why, r"predicted: [0-9.e-]+ ms, error at most [0-9.e-]+\)")
        self.assertIn("two-pass", self.why("--max-error", "6e-6", "--payload", "packed"))
        self.assertIn("exact", self.why())

    def test_prices_decide(self):
        profile = self.done_json("devices", "--json")
        for name, method in [("two-pass compute", "two-pass"), ("exact packed", "exact"),
                             ("deferred packed", "deferred")]:
            for kind, prices in profile["calibration"].items():
                if kind != "measured":
                    prices.clear()
                    prices["frame"] = 1e6 if kind == name else 1e8
            self.write("limits.json", json.dumps(profile))
            why = self.why("--max-error", "0.5", "--limits", "limits.json")
            self.assertTrue(why.startswith(f"why: {method} is the cheapest"), why)

    def test_bound_is_kept(self):
        self.fill_cache()
        self.done("render", "ball.ply", "-o", "truth.exr", *VIEW, "--method", "reference")
        for bound in [0.05, 1e-3, 1e-4, 1e-5]:
            self.done("render", "ball.ply", "-o", "out.exr", *VIEW, "--max-error", str(bound),
                      "--stats", "stats.json")
            error = self.done_json("compare", "--json", "out.exr", "truth.exr")
            self.assertLessEqual(error["covered"]["mean_absolute"], bound)
            self.assertIn("cheapest within an error of", json.loads(self.read("stats.json"))["plan"])

    def test_said_is_kept(self):
        """The error that is said at most holds whatever else moves colours; of what it leaves out, a line."""
        self.fill_cache()
        for options, bounds in [([], ["1e-2", "1e-5"]), (["--shade", "splat"], ["1e-2", "1e-5"]),
                                (["--shade", "flat"], ["1e-2", "1e-4"]), (["--light-cube", "on"], ["1e-2"])]:
            truth = options if "--shade" in options else []
            self.done("render", "ball.ply", "-o", "truth.exr", *VIEW, "--method", "reference", *truth)
            for bound in bounds:
                self.done("render", "ball.ply", "-o", "out.exr", *VIEW, "--max-error", bound, *options)
                said = re.search(r"error at most ([0-9.e-]+)", self.why("--max-error", bound, *options))
                error = self.done_json("compare", "--json", "out.exr", "truth.exr")
                self.assertLessEqual(error["covered"]["mean_absolute"], 1.05 * float(said[1]), options)
        run = self.run_tool("render", "ball.ply", "-o", "out.exr", *VIEW, "--max-error", "1e-3", "--half")
        self.assertEqual((run.returncode, run.stderr.count("\n")), (0, 1), run.stderr)
        self.assertIn("--half", run.stderr)

    def test_verbose_says_why(self):
        self.fill_cache()
        run = self.run_tool("render", "ball.ply", "-o", "out.exr", *VIEW, "--verbose")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, r"(?m)^stipple: \S+ is the cheapest within an error of 0\.0001 \(predicted")

    def test_calibration_is_kept(self):
        path = self.fill_cache()
        with open(path, encoding="ascii") as file:
            profile = json.load(file)
        profile["calibration"]["exact id"] = {"frame": 12345}
        with open(path, "w", encoding="ascii") as file:
            json.dump(profile, file)
        shown = self.done_json("devices", "--json")["calibration"]
        self.assertEqual((shown["measured"], shown["exact id"]), (True, {"frame": 12345}))

    def test_damaged_cache(self):
        path = self.fill_cache()
        with open(path, "w", encoding="ascii") as file:
            file.write('{ "device": ')
        run = self.run_tool("render", "ball.ply", "-o", "out.exr", *VIEW)
        self.assertEqual((run.returncode, run.stderr.count("\n")), (0, 1), run.stderr)
        self.assertIn(os.path.basename(path), run.stderr)

    def test_wrong_bounds(self):
        for bound in ["0", "-1", "nan", "x", ""]:
            self.fails(2, ["--max-error"], "render", "ball.ply", "-o", "x.exr", "--max-error", bound)


command.main()
