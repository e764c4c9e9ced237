#!/usr/bin/env python3
"""Range images by the command: folders and scenes, what --help says of them, and what is refused."""
import json
import os
import shutil
import struct

import command

WIDE, HIGH = 24, 18


def pgm(value):
    head = f"P5 {WIDE} {HIGH} 65535\n".encode()
    return head + b"".join(struct.pack(">H", value(i % WIDE, i // WIDE)) for i in range(WIDE * HIGH))


def ppm(color):
    return f"P6 {WIDE} {HIGH} 255\n".encode() + bytes(color) * (WIDE * HIGH)


class Range(command.CommandTest):
    def setUp(self):
        super().setUp()
        for name in ("depth", "color"):
            os.makedirs(self.path(os.path.join("scan", name)))
        for n, color in ((1, (255, 0, 0)), (2, (0, 0, 255))):
            self.write(f"scan/depth/{n}.pgm", pgm(lambda x, y: 0 if x == 3 else 2000))
            self.write(f"scan/color/{n}.ppm", ppm(color))
        self.write("scan/intrinsics.txt", "fx 30\nfy 30\ncx 12\ncy 8.5\ndepth_scale 1000\n")
        self.write("scan/pose.txt", "0 0 0 0 0 0 1\n0.1 0 0 0 0 0 1\n")
        self.reference = ["--method", "reference"]

    def test_a_folder_has_its_first_frames_camera(self):
        self.done("render", "scan", *self.reference, "-o", "a.exr", "--write-camera", "c.json")
        view = json.loads(self.read("c.json"))
        self.assertEqual((view["width"], view["height"]), (WIDE, HIGH))
        self.assertAlmostEqual(view["intrinsics"]["cx"], 12.5)

    def test_info(self):
        told = self.done_json("info", "--json", "scan")[0]
        self.assertEqual(told["range"]["frames"], 2)
        self.assertEqual(told["range"]["holes"], 2 * HIGH)
        self.assertEqual(told["splats"], 2 * (WIDE - 1) * HIGH)
        self.assertAlmostEqual(told["range"]["deviation_median"], 1.43e-3 * 4, places=6)
        self.assertEqual(told["would"]["method"], "axis")
        self.assertGreater(told["range"]["sources"], 1.5)
        self.assertIn("ellipsoids", self.done("info", "scan"))

    def test_every_choice_is_another_picture(self):
        pictures = set()
        for more in ([], ["--uncertainty", "0"], ["--uncertainty", "20"], ["--color-by", "views"],
                     ["--range-splats", "discs"]):
            self.done("render", "scan", *self.reference, *more, "-o", "a.exr")
            pictures.add(self.read("a.exr"))
        self.assertEqual(len(pictures), 5)

    def test_a_scene_file_says_the_same(self):
        frames = [{"depth": f"scan/depth/{n}.pgm", "color": f"scan/color/{n}.ppm",
                   "pose": [0.1 * (n - 1), 0, 0, 0, 0, 0, 1]} for n in (1, 2)]
        self.write("s.json", json.dumps({"range": {"intrinsics_file": "scan/intrinsics.txt",
                                                   "frames": frames}}))
        self.write("t.json", json.dumps({"range": "scan"}))
        for scene, out in (("scan", "a.exr"), ("s.json", "b.exr"), ("t.json", "c.exr")):
            self.done("render", scene, *self.reference, "-o", out)
        self.assertEqual(self.read("a.exr"), self.read("b.exr"))
        self.assertEqual(self.read("a.exr"), self.read("c.exr"))

    def test_a_bound(self):
        self.promises_no_error("scan")
        discs = self.done("plan", "scan", "--range-splats", "discs", "--max-error", "1e-3")
        self.assertIn("\nconsidered (predicted, the cheapest first):\n", discs)

    def test_what_is_refused(self):
        self.fails(1, ["discs"], "render", "scan", "--method", "exact", "-o", "a.exr")
        self.fails(2, ["--uncertainty"], "render", "scan", "--uncertainty", "-1", "-o", "a.exr")
        self.fails(2, ["--range-splats"], "render", "scan", "--range-splats", "cubes", "-o", "a.exr")
        shutil.copytree(self.path("scan"), self.path("still"))
        self.write("scan/pose.txt", "0 0 0 0 0 0 nan\n")
        self.fails(3, ["pose.txt: byte 0"], "render", "scan", "-o", "a.exr")
        self.fails(1, ["--range-splats discs"], "prepare", "still", "-o", "a.ply", "--fit", "1")
        os.remove(self.path("scan/intrinsics.txt"))
        self.fails(3, ["scan: a folder", "no intrinsics.txt"], "render", "scan", "-o", "a.exr")


command.main()
