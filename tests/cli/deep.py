#!/usr/bin/env python3
"""--deep: files that others flatten to the flat picture."""
import re
import subprocess

import command

BASIC = ["--size", "60x40", "--view", "front", "--cull", "none"]


def sheets():
    """Five squares of points behind each other."""
    return [(0.04 * x - 1, 0.04 * y - 1, 0.3 * z) for z in range(5) for x in range(51)
            for y in range(51)]


class Deep(command.CommandTest):
    def tool(self, *arguments):
        run = subprocess.run(["oiiotool", *arguments], cwd=self.folder, capture_output=True,
                             text=True, check=True)
        return run.stdout

    def flattened(self, bound, flat="out.exr", deep="deep.exr"):
        """The largest difference of R G B A, which `bound` bounds."""
        self.tool(deep, "--flatten", "--ch", "R,G,B,A", "-o", "flattened.exr")
        text = self.tool(flat, "--ch", "R,G,B,A", "flattened.exr", "--warn", "1", "--fail",
                         str(bound), "--hardfail", str(bound), "--diff")
        self.assertIn("PASS", text)

    def render(self, scene, *options):
        self.done("render", scene, "-o", "out.exr", "--deep", "deep.exr", *BASIC, *options)

    def most(self):
        info = self.tool("--info", "-v", "deep.exr")
        return int(re.search(r"maxSamplesPerPixel: (\d+)", info)[1])

    # A sum of n terms of float32, each rounded a few times: 2 layers of a ball, 5 sheets.
    def test_exact_and_reference(self):
        for way in ("exact", "reference"):
            self.render("ball.ply", "--opacity", "0.5", "--transparency", way)
            self.flattened(1e-6)
            self.assertGreaterEqual(self.most(), 2)
            self.assertIn("deep float openexr", self.tool("--info", "-v", "deep.exr"))

    def test_sheets(self):
        self.write("sheets.ply", command.ply(sheets()))
        for compression in ("zip", "none"):
            self.render("sheets.ply", "--opacity", "0.3", "--compression", compression)
            self.flattened(2e-6)
            self.assertGreaterEqual(self.most(), 5)

    # Rounded to half, a value v is off by up to v / 2048, of each layer's colour and alpha.
    def test_half(self):
        self.render("ball.ply", "--opacity", "0.4", "--half")
        self.flattened(4 / 2048)
        self.assertIn("16-bit floating-point", subprocess.run(
            ["exrheader", self.path("deep.exr")], capture_output=True, text=True).stdout)

    def test_opaque_is_one_layer(self):
        for method in ("exact", "two-pass", "reference"):
            self.render("ball.ply", "--method", method)
            self.flattened(1e-7)
            self.assertEqual(self.most(), 1)

    def test_background_is_no_layer(self):
        self.render("ball.ply", "--opacity", "0.5")
        without = self.read("deep.exr")
        self.render("ball.ply", "--opacity", "0.5", "--background", "1,2,3")
        self.assertEqual(self.read("deep.exr"), without)

    def test_tiles(self):
        self.render("ball.ply", "--opacity", "0.5")
        whole = self.read("deep.exr")
        self.render("ball.ply", "--opacity", "0.5", "--tile-memory", "1M")
        self.assertEqual(self.read("deep.exr"), whole)

    def test_alone(self):
        self.done("render", "ball.ply", "--deep", "deep.exr", *BASIC, "--opacity", "0.5")
        self.assertGreaterEqual(self.most(), 2)

    def test_frames(self):
        camera = ('[{"world_to_camera": [1,0,0,0, 0,1,0,0, 0,0,1,%s, 0,0,0,1], "fov_y_deg": 40, '
                  '"width": 30, "height": 20, "near": 0.1, "far": null}%s')
        self.write("path.json", camera % (-5, ",") + (camera % (-6, "]"))[1:])
        self.done("render", "ball.ply", "-o", "f%d.exr", "--deep", "d%d.exr", "--camera",
                  "path.json", "--frames", "0:1", "--opacity", "0.5")
        for i in "01":
            self.flattened(1e-6, "f%s.exr" % i, "d%s.exr" % i)

    def test_refused(self):
        scene = ["render", "ball.ply", "-o", "out.exr", "--deep", "deep.exr", *BASIC]
        self.fails(1, ["deep", "samples"], *scene, "--samples", "4")
        self.fails(2, ["two outputs"], *scene[:5], "out.exr")
        self.fails(2, ["--deep"], *scene[:5], "deep.png")
        self.fails(1, ["no/deep.exr"], *scene[:5], "no/deep.exr")


class NoDevice(command.CommandTest):
    """The reference needs no Vulkan, however it is asked for."""

    def test_reference(self):
        hidden = {"VK_ICD_FILENAMES": "/nonexistent", "VK_DRIVER_FILES": "/nonexistent"}
        self.done("render", "ball.ply", "-o", "a.exr", *BASIC, "--opacity", "0.5",
                  "--transparency", "reference", env=hidden)
        self.done("render", "ball.ply", "-o", "b.exr", *BASIC, "--opacity", "0.5", "--method",
                  "reference", env=hidden)
        self.assertIn("PASS", subprocess.run(
            ["oiiotool", "a.exr", "b.exr", "--fail", "0", "--diff"], cwd=self.folder,
            capture_output=True, text=True).stdout)
        # An opaque scene ignores it.
        run = self.run_tool("render", "ball.ply", "-o", "a.exr", *BASIC, "--transparency",
                            "reference", env=hidden)
        self.assertEqual(run.returncode, 1)


command.main()
