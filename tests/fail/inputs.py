#!/usr/bin/env python3
"""Bad input: one line with the file's name and what is wrong; status 3; the old output stays."""
import gzip
import os
import shutil
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

BALL = command.ply(command.sphere(500))
SPLAT_3D = (b"ply\nformat ascii 1.0\nelement vertex 1\n" + b"".join(
    b"property float %s\n" % name for name in
    b"x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split())
    + b"end_header\n0 0 0 1 1 1 0 0 0 0 1 0 0 0\n")
# Name, content, words of the line beside the name.
DAMAGED = [
    ("empty.ply", b"", ["empty"]),
    ("short.ply", BALL[:-5], []),
    ("lying.ply", command.ply(command.sphere(500), claimed=1 << 60), []),
    ("no_points.ply", command.ply([]), ["no points to draw: there are none"]),
    ("not_finite.ply", command.ply([(float("nan"), 0, 0)] * 3), ["no points to draw: none of 3 has"]),
    ("headless.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 4\n", []),
    ("binary.xyz", bytes(range(256)) * 16, []),
    ("cut.ply.gz", gzip.compress(BALL, mtime=0)[:-200], []),
    ("gaussians.ply", SPLAT_3D, ["Gaussian"]),
    ("scene.json", b'{"points": ', []),
    ("lost.json", b'{"points": [{"file": "not_there.ply"}]}', []),
]


SMALL_DEVICE = (b'{"device": "d", "driver": "d", "features": [], "heap_bytes": 1000000, '
                b'"max_allocation": 4096, "max_image_size": 64, "max_image_layers": 1, '
                b'"max_workgroups": 65535, "max_texels": 65536, "processor": 1}')


class Inputs(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.write("out.exr", b"the old file")

    def refused(self, words, *arguments, **more):
        return self.fails(3, words, "render", *arguments, "-o", "out.exr", "--method",
                          "reference", **more)

    def test_damaged(self):
        for name, content, words in DAMAGED:
            with self.subTest(name=name):
                self.write(name, content)
                shown = "not_there.ply" if name == "lost.json" else name
                self.refused([shown, *words], name)

    def test_not_a_file(self):
        self.refused(["missing.ply", "No such file"], "missing.ply")
        self.refused([self.folder], self.folder)

    def test_pipes(self):
        """What cannot be mapped is said to be that, in one line."""
        self.refused(["/dev/stdin", "a pipe", "only files are read"], "/dev/stdin", input="1 2 3\n")
        os.mkfifo(self.path("pipe.ply"))
        self.refused(["pipe.ply", "a pipe"], "pipe.ply")
        self.refused(["/dev/null", "device"], "/dev/null")

    def test_all_clipped(self):
        self.refused(["ball.ply", "clip"], "ball.ply", "--clip-box", "5,5,5,6,6,6")

    def test_not_readable(self):
        os.chmod(self.path("ball.ply"), 0)
        os.chmod(self.folder, 0o777)
        tool = self.path("stipple")
        shutil.copy(command.TOOL, tool)
        os.chmod(tool, 0o755)
        user = 65534 if os.getuid() == 0 else None
        more = {"user": user, "group": user, "extra_groups": []} if user else {}
        old, command.TOOL = command.TOOL, tool
        try:
            self.refused(["ball.ply", "ermission denied"], "ball.ply", **more)
        finally:
            command.TOOL = old

    def test_cameras(self):
        for name, content in [("c1.json", b"{}"), ("c2.json", b"["), ("c3.json", b'"x"')]:
            self.write(name, content)
            self.refused([name], "ball.ply", "--camera", name)
        self.refused(["c4.json"], "ball.ply", "--camera", "c4.json")

    def test_limits(self):
        self.write("limits.json", b"{]")
        self.fails(3, ["limits.json"], "plan", "ball.ply", "--limits", "limits.json")
        self.write("small.json", SMALL_DEVICE)
        small = ["plan", "ball.ply", "--limits", "small.json"]
        self.fails(1, ["4096 in one buffer", "--method reference"], *small, "--method", "exact")
        self.assertIn("reference is chosen", self.done(*small))

    def test_damaged_camera_path(self):
        """What comes before the damaged camera is done, and the line says which one it is."""
        self.done("render", "ball.ply", "--stats", "x.json", "--write-camera", "one.json",
                  "--method", "reference", "--size", "8x8")
        one = self.read("one.json").decode()
        for damaged in ['{}', '7', '{"world_to_camera": [1, 2]}', 'null', '[]']:
            self.write("path.json", "[%s, %s, %s]" % (one, damaged, one))
            run = self.run_tool("render", "ball.ply", "--camera", "path.json", "--frames", "0:2",
                                "-o", "f.%d.exr", "--method", "reference", "--size", "8x8")
            self.assertEqual(run.returncode, 3, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            self.assertIn("[1]", run.stderr)
            made = sorted(name for name in os.listdir(self.folder) if name.startswith("f."))
            self.assertEqual(made, ["f.0.exr"])
            os.unlink(self.path("f.0.exr"))

    def test_pictures(self):
        self.fails(3, ["missing.exr"], "compare", "missing.exr", "out.exr")
        self.fails(3, ["out.exr"], "compare", "out.exr", "out.exr")

    def test_pictures_of_two_sizes(self):
        for size in ["8x8", "8x9"]:
            self.done("render", "ball.ply", "-o", size + ".exr", "--size", size, "--method",
                      "reference")
        self.fails(3, ["8x8", "8x9"], "compare", "8x8.exr", "8x9.exr")

    def test_info_goes_on(self):
        run = self.run_tool("info", "missing.ply", "ball.ply")
        self.assertEqual(run.returncode, 3)
        self.assertIn("missing.ply", run.stderr)
        self.assertIn("2000", run.stdout)


command.main()
