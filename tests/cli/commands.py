#!/usr/bin/env python3
"""info, plan, prepare, compare and devices on good input, and --help and --version of all."""
import json

import command

COMMANDS = ["info", "render", "plan", "prepare", "compare", "report", "devices"]
REFERENCE = ["--method", "reference", "--size", "64x64"]


class Commands(command.CommandTest):
    def test_help(self):
        overview = self.done("--help")
        for name in COMMANDS:
            self.assertIn("\n  %-9s " % name, overview)
            text = self.done(name, "--help")
            self.assertEqual(text, self.done("help", name))
            self.assertTrue(text.startswith(f"usage: stipple {name} "))
            for line in text.split("\nExamples:")[0].splitlines():
                self.assertLessEqual(len(line), 80, line)

    def test_version(self):
        version = self.done("--version")
        self.assertRegex(version, r"^stipple \d+\.\d+\.\d+\n$")
        self.assertEqual(version, self.done("-v"))
        self.assertEqual(version, self.done("render", "--version"))

    def test_info(self):
        text = self.done("info", "ball.ply")
        for word in ["ball.ply", "PLY binary little-endian", "2000", "given", "nothing",
                     "stipple render ball.ply -o ball.exr"]:
            self.assertIn(word, text)

    def test_info_json(self):
        points = command.sphere(500) + [(float("nan"), 0, 0)]
        self.write("odd name.ply", command.ply(points))
        ball, odd = self.done_json("info", "--json", "ball.ply", "odd name.ply")
        self.assertEqual((ball["points"], ball["splats"], ball["wrong"]), (2000, 2000, []))
        self.assertEqual((odd["points"], odd["splats"], odd["not_finite"]), (501, 500, 1))
        self.assertEqual(len(odd["wrong"]), 1)
        self.assertIn('"odd name.ply"', odd["would"]["command"])
        for low, high in zip(ball["bounds"][:3], ball["bounds"][3:]):
            self.assertAlmostEqual(low, -1, 2)
            self.assertAlmostEqual(high, 1, 2)

    def test_info_far_from_the_origin(self):
        """Coordinates as of UTM: what is printed tells the corners apart."""
        far = [(5e5 + 1e-3 * x, 4649776.25 + 2e-3 * y, 100 + x * y) for x in range(9)
               for y in range(9)]
        self.write("far.xyz", "".join("%.6f %.6f %.6f\n" % p for p in far))
        lines = self.done("info", "far.xyz").splitlines()
        low, high = ([float(v) for v in line.split()[1:]] for line in lines
                     if line.split()[0] in ("from", "to"))
        for a, b, size in zip(low, high, (8e-3, 16e-3, 64)):
            self.assertAlmostEqual((b - a) / size, 1, 4)
        self.assertEqual(self.done_json("info", "--json", "far.xyz")[0]["float_step"], 0)

    def test_float32_far_from_the_origin(self):
        """Steps of 1/2 at 4.6 million, for points that lie 1 apart: whole metres, whatever they were."""
        for name, spacing, coarse in [("coarse", 1, True), ("fine", 100, False)]:
            points = [(5e5 + spacing * x, 4649776 + spacing * y, 100) for x in range(9) for y in range(9)]
            self.write(name + ".xyz", "".join("%.0f %.0f %.0f\n" % p for p in points))
            told = self.done_json("info", "--json", name + ".xyz")[0]
            self.assertEqual(told["float_step"], 0.5)
            self.assertEqual(any("float32" in line for line in told["wrong"]), coarse)
            run = self.run_tool("render", name + ".xyz", "-o", "a.exr", *REFERENCE)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (0, 1 if coarse else 0))
            self.assertEqual("in steps of 0.5" in run.stderr, coarse)

    def test_a_camera_is_no_scene(self):
        self.done("render", "ball.ply", "-o", "a.exr", "--write-camera", "view.json", *REFERENCE)
        self.fails(3, ["world_to_camera", "--camera"], "render", "view.json", "-o", "a.exr")

    def test_plan(self):
        self.assertEqual(self.done("plan", "ball.ply"), self.done("plan", "ball.ply"))
        for method in ["deferred", "two-pass", "exact"]:
            self.assertIn(method, self.done("plan", "ball.ply", "--method", method))

    def test_options_of_groups_without_groups(self):
        for command in (["plan", "ball.ply"],
                        ["render", "ball.ply", "-o", "a.exr", *REFERENCE[2:]]):
            method = ["--method", "reference" if command[0] == "render" else "exact"]
            for options in (["--overlap", "0.5"], ["--relax", "none"], ["--groups", "9"]):
                run = self.run_tool(*command, *method, *options)
                self.assertEqual(run.returncode, 0)
                self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                self.assertIn(f"warning: {options[0]} has no effect", run.stderr)
                self.done(*command, *method, *options, "--quiet")
        self.done("plan", "ball.ply", "--method", "deferred", "--overlap", "0.5", "--relax", "none",
                  "--groups", "9")
        self.done("plan", "ball.ply", "--opacity", "0.5", "--transparency", "fast", "--groups", "3")

    def test_plan_takes_a_device_profile(self):
        self.write("limits.json", self.done("devices", "--json"))
        profile = json.loads(self.read("limits.json"))
        self.assertEqual(list(profile)[:10],
                         ["device", "driver", "features", "heap_bytes", "max_allocation",
                          "max_image_size", "max_image_layers", "max_workgroups", "max_texels",
                          "processor"])
        whole = self.done("plan", "ball.ply", "--limits", "limits.json")
        profile["features"] = []
        self.write("limits.json", json.dumps(profile))
        self.assertNotEqual(self.done("plan", "ball.ply", "--limits", "limits.json"), whole)

    def test_a_warning_of_groups_comes_once(self):
        """However many overlaps are tried."""
        run = self.run_tool("plan", "ball.ply", "--groups", "2", "--max-error", "0.1", "--method",
                            "deferred")
        self.assertEqual((run.returncode, run.stderr.count("needs more than 2 groups")), (0, 1))

    def test_devices(self):
        text = self.done("devices")
        for word in ["driver", "memory", "has", "lacks"]:
            self.assertIn("\n  " + word, text)
        name = self.done_json("devices", "--json")["device"]
        self.assertEqual(self.done("devices", "--device", name.upper()), self.done("devices", "--device", name))
        for words in (["devices"], ["render", "ball.ply", "-o", "a.exr"]):
            self.fails(1, ['called "none such"'], *words, "--device", "none such")

    def test_prepare(self):
        self.done("prepare", "ball.ply", "-o", "splats.ply")
        self.done("prepare", "splats.ply", "-o", "again.ply")
        self.done("prepare", "again.ply", "-o", "third.ply")
        self.assertEqual(self.read("again.ply"), self.read("third.ply"))
        for name in ["ball", "splats"]:
            self.done("render", name + ".ply", "-o", name + ".exr", *REFERENCE)
        error = self.done_json("compare", "--json", "splats.exr", "ball.exr")
        self.assertEqual(error["all"]["maximum"], 0)

    def test_prepare_with_groups(self):
        self.done("prepare", "ball.ply", "-o", "groups.ply", "--group", "--overlap", "1")
        self.assertNotEqual(len(self.read("groups.ply")), 0)
        self.done("prepare", "ball.ply", "-o", "plain.ply")
        self.assertGreater(len(self.read("groups.ply")), len(self.read("plain.ply")))

    def test_compare(self):
        self.done("render", "ball.ply", "-o", "a.exr", *REFERENCE)
        self.done("render", "ball.ply", "-o", "b.exr", *REFERENCE, "--kernel", "gauss")
        same = self.done_json("compare", "--json", "a.exr", "a.exr")
        self.assertIsNone(same["covered"]["psnr"])
        self.assertEqual(same["all"]["pixels"], 64 * 64)
        other = self.done_json("compare", "--json", "a.exr", "b.exr")
        self.assertGreater(other["covered"]["psnr"], 20)
        self.assertGreater(other["covered"]["rmse"], 0)
        halved = self.done_json("compare", "--json", "--epsilon", "2", "a.exr", "b.exr")
        self.assertAlmostEqual(halved["depth_mean"], other["depth_mean"] / 2, 12)
        for word in ["PSNR", "RMSE", "FLIP", "normal angle", "coverage"]:
            self.assertIn(word, self.done("compare", "a.exr", "b.exr"))
        self.fails(1, ["PSNR", "999"], "compare", "a.exr", "b.exr", "--fail-under-psnr", "999")
        self.done("compare", "a.exr", "a.exr", "--fail-under-psnr", "999")


command.main()
