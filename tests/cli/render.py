#!/usr/bin/env python3
"""What `stipple render` writes: channels, types and compression as asked for, frames of a camera
path, statistics. By --method reference: what is tested is the command, not a renderer."""
import json
import re
import struct
import subprocess

import command

BASIC = ["render", "ball.ply", "-o", "out.exr", "--method", "reference", "--size", "40x30"]
CHANNELS = ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z"]
STATS = ["build", "device", "driver", "points", "splats", "splats_drawn", "groups", "grouping",
         "method", "path", "passes", "frame_ms", "cold_ms", "bytes", "peak_rss", "plan"]


def png_shape(data):
    """(width, height, colour type); 6 is RGBA."""
    return (*struct.unpack(">II", data[16:24]), data[25])


class Render(command.CommandTest):
    def header(self, name="out.exr"):
        run = subprocess.run(["exrheader", self.path(name)], capture_output=True, text=True,
                             check=True)
        return run.stdout

    def channels(self, name="out.exr"):
        """{name: type} as Debian's exrheader sees it."""
        found = re.findall(r"^    ([\w.]+), (16-bit|32-bit) ([\w-]+)", self.header(name), re.M)
        return {channel: f"{bits} {kind}" for channel, bits, kind in found}

    def test_default_channels(self):
        self.done(*BASIC)
        self.assertEqual(self.channels(), dict.fromkeys(CHANNELS, "32-bit floating-point"))
        self.assertIn("zip, multi-scanline", self.header())
        self.assertIn("(0 0) - (39 29)", self.header())

    def test_aovs(self):
        self.done(*BASIC, "--aov", "albedo,P,weight,fragments", "--aov", "coverage,id,layers")
        added = ["albedo.R", "albedo.G", "albedo.B", "P.X", "P.Y", "P.Z", "weight", "fragments",
                 "coverage", "id", "layers"]
        channels = self.channels()
        self.assertEqual(sorted(channels), sorted(CHANNELS + added))
        self.assertEqual(channels["id"], "32-bit unsigned")

    def averages(self, name="out.exr"):
        """{channel: its mean}, as oiiotool has it."""
        run = subprocess.run(["oiiotool", "--stats", self.path(name)], capture_output=True,
                             text=True, check=True)
        values = re.search(r"Stats Avg: ([-\d. ]+)", run.stdout)[1].split()
        names = re.search(r"channel list: ([^\n]+)", subprocess.run(
            ["oiiotool", "--info", "-v", self.path(name)], capture_output=True, text=True,
            check=True).stdout)[1].split(", ")
        return dict(zip(names, map(float, values)))

    def test_color_by(self):
        """What has no colours of its own gets them from height or normal."""
        means = {}
        for by in ["rgb", "height", "normal"]:
            self.done(*BASIC, "--color-by", by, "--aov", "albedo")
            means[by] = self.averages()
        self.assertEqual(means["rgb"]["albedo.R"], means["rgb"]["albedo.B"])
        for by in ["height", "normal"]:
            gap = abs(means[by]["albedo.R"] - means[by]["albedo.B"])
            self.assertGreater(gap, 0.02, f"{by}: {means[by]}")
    def sky(self, name="sky.hdr"):
        """A Radiance map of 8 x 4 texels, all of them 0.5, 0.25, 1."""
        self.write(name, b"#?RADIANCE\n\n-Y 4 +X 8\n" + bytes([64, 32, 128, 128]) * 32)
        return name

    def test_environment(self):
        self.done(*BASIC, "--environment", self.sky(), "--background", "environment",
                  "--environment-rotation", "30", "--environment-intensity", "2",
                  "--reflectance", "0.9,0.5,0.2", "--roughness", "0.5", "--ior", "1.4",
                  "--compression", "none")
        # Scanline 0 of an uncompressed file: A B G N.X N.Y N.Z R Z, 40 floats each.
        data = self.read("out.exr")
        line = struct.unpack_from("<320f", data, len(data) - 30 * (8 + 40 * 8 * 4) + 8)
        self.assertEqual([line[40 * channel] for channel in (0, 6, 2, 1)], [1, 0.5, 0.25, 1])

    def test_environment_of_a_scene(self):
        self.sky()
        self.write("scene.json", json.dumps({
            "points": [{"file": "ball.ply", "material": {"ior": [1.4, 1.5, 1.6], "roughness": 0.2}}],
            "environment": {"file": "sky.hdr", "rotation": 90, "intensity": 2}}))
        self.done("render", "scene.json", "-o", "out.exr", *BASIC[4:], "--background",
                  "environment")

    def test_environment_refused(self):
        self.sky()
        self.fails(3, ["missing.exr"], *BASIC, "--environment", "missing.exr")
        self.fails(3, ["neither OpenEXR nor Radiance"], *BASIC, "--environment", "ball.ply")
        self.fails(1, ["the scene has none"], *BASIC, "--background", "environment")
        for option, value in [("--ior", "0"), ("--ior", "1,2"), ("--roughness", "1.1"),
                              ("--roughness", "0,0,0"), ("--reflectance", "-0.1"),
                              ("--environment-intensity", "0"), ("--layers", "both")]:
            self.fails(2, [option], *BASIC, "--environment", "sky.hdr", option, value)

    def test_dropped(self):
        with open(self.path("nan.ply"), "w", encoding="ascii") as file:
            file.write("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                       "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\nnan 0 0\n")
        run = self.run_tool("render", "nan.ply", *BASIC[2:])
        self.assertEqual((run.returncode, run.stderr),
                         (0, "stipple: warning: nan.ply: 1 point is not finite, or beyond 1e18: dropped\n"))

    def test_half(self):
        self.done(*BASIC, "--half", "--aov", "albedo,P")
        for name, kind in self.channels().items():
            half = name in "RGBA" or name.startswith(("N.", "albedo."))
            self.assertEqual(kind[:6], "16-bit" if half else "32-bit", name)

    def test_compression(self):
        for name, words in [("none", "none"), ("zips", "zip, individual"), ("piz", "piz")]:
            self.done(*BASIC, "--compression", name)
            self.assertIn(words, self.header())

    def test_preview(self):
        self.done(*BASIC, "--preview", "a.png")
        self.done(*BASIC[:2], *BASIC[4:], "--preview", "b.png", "--exposure", "2")
        self.assertEqual(png_shape(self.read("a.png")), (40, 30, 6))
        self.assertNotEqual(self.read("a.png"), self.read("b.png"))

    def test_background(self):
        """Straight alpha on the command line: half-opaque red arrives multiplied."""
        self.done(*BASIC, "--background", "1,0,0,0.5")
        run = subprocess.run(["oiiotool", "--dumpdata", self.path("out.exr")],
                             capture_output=True, text=True, check=True)
        corner = re.search(r"Pixel \(0, 0\): ([-\d.infe+ ]+)", run.stdout)[1].split()
        self.assertEqual([float(v) for v in corner[:4]], [0.5, 0, 0, 0.5])

    def test_same_options_same_bytes(self):
        self.done(*BASIC, "--threads", "1")
        first = self.read("out.exr")
        self.done(*BASIC, "--threads", "3")
        self.assertEqual(self.read("out.exr"), first)

    def test_camera_round_trip(self):
        self.done(*BASIC, "--view", "40,-20", "--fov", "50", "--write-camera", "c.json")
        first = self.read("out.exr")
        self.done(*BASIC[:6], "--camera", "c.json")
        self.assertEqual(self.read("out.exr"), first)

    def test_views_differ(self):
        for view in ["front", "back", "left", "right", "top", "bottom", "iso"]:
            self.done(*BASIC, "--view", view, "--write-camera", view + ".json")
        cameras = {self.read(v + ".json") for v in
                   ["front", "back", "left", "right", "top", "bottom", "iso"]}
        self.assertEqual(len(cameras), 7)
        right = json.loads(self.read("right.json"))["world_to_camera"]
        # The right view looks along -x: the camera's backward axis is +x, its right is -z.
        for row, wanted in [(right[2], [1, 0, 0]), (right[0], [0, 0, -1])]:
            for value, want in zip(row[:3], wanted):
                self.assertAlmostEqual(value, want, 12)

    def test_frames(self):
        for view in ["front", "right", "top"]:
            self.done(*BASIC, "--view", view, "--write-camera", view + ".json")
        path = [json.loads(self.read(v + ".json")) for v in ["front", "right", "top"]]
        self.write("path.json", json.dumps(path))
        self.done("render", "ball.ply", "-o", "f.%04d.exr", "--camera", "path.json", "--frames",
                  "1:2", "--method", "reference", "--stats", "s.json", "--preview", "p%d.png")
        names = self.listing()
        self.assertTrue({"f.0001.exr", "f.0002.exr", "p1.png", "p2.png"} <= set(names))
        self.assertNotIn("f.0000.exr", names)
        self.assertEqual([list(s) for s in json.loads(self.read("s.json"))], [STATS, STATS])

    def test_path_without_frames(self):
        self.done(*BASIC, "--write-camera", "c.json")
        self.write("path.json", "[%s, %s]" % ((self.read("c.json").decode(),) * 2))
        run = self.run_tool(*BASIC, "--camera", "path.json")
        self.assertEqual(run.returncode, 0)
        self.assertIn("warning", run.stderr)
        self.assertIn("--frames 0:1", run.stderr)
        self.done(*BASIC, "--camera", "path.json", "--quiet")

    def test_stats_alone(self):
        before = set(self.listing())
        self.done("render", "ball.ply", "--method", "reference", "--size", "16x16", "--stats",
                  "s.json")
        self.assertEqual(set(self.listing()) - before, {"s.json"})
        stats = json.loads(self.read("s.json"))
        self.assertEqual(list(stats), STATS)
        self.assertEqual((stats["points"], stats["splats"], stats["method"]),
                         (2000, 2000, "reference"))
        self.assertEqual(stats["splats_drawn"], 2000)
        self.assertEqual(sorted(stats["cold_ms"]),
                         ["first_frame", "load", "prepare", "upload", "write"])
        self.assertEqual(sorted(stats["frame_ms"]), ["max", "median", "min"])
        self.assertEqual(sorted(stats["bytes"]), ["peak", "scene", "transient"])
        self.assertGreater(stats["peak_rss"], 1 << 20)
        self.assertTrue(stats["plan"])

    def test_splats_drawn(self):
        """Of a ball about half face the eye, fewer by perspective."""
        self.done("render", "ball.ply", "--method", "reference", "--size", "16x16", "--cull",
                  "back", "--stats", "s.json")
        drawn = json.loads(self.read("s.json"))["splats_drawn"]
        self.assertTrue(600 < drawn < 1000, drawn)


command.main()
