#!/usr/bin/env python3
"""Volumes by the command: what describes a raw file, how it looks, and what is refused."""
import gzip
import json

import command

SIDE = 16


def ball():
    """uint8: 200 within a ball, 90 in a shell around it, a little noise without."""
    values = []
    for i in range(SIDE ** 3):
        place = (i % SIDE, i // SIDE % SIDE, i // SIDE // SIDE)
        r2 = sum((c - (SIDE - 1) / 2) ** 2 for c in place)
        values.append(200 if r2 < 4 ** 2 else 90 if r2 < 5.5 ** 2 else i * 7 % 5)
    return bytes(values)


class Volume(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.write("ball.raw", ball())
        self.dims = ["--volume-dims", f"{SIDE},{SIDE},{SIDE}"]
        self.look = ["--method", "reference", "--size", "32x32"]

    def test_flags_and_a_description_give_the_same_bits(self):
        self.done("render", "ball.raw", *self.dims, *self.look, "-o", "a.exr")
        self.write("ball.raw.json", json.dumps({"dims": [SIDE] * 3, "dtype": "uint8"}))
        self.done("render", "ball.raw", *self.look, "-o", "b.exr", "--preview", "b.png")
        self.assertEqual(self.read("a.exr"), self.read("b.exr"))
        self.write("packed.raw", gzip.compress(ball()))
        self.done("render", "packed.raw", *self.dims, *self.look, "-o", "c.exr")
        self.assertEqual(self.read("a.exr"), self.read("c.exr"))

    def test_info(self):
        told = self.done_json("info", "--json", "ball.raw", *self.dims, "--volume-spacing", "1,1,2",
                              "--transfer-function", "bone")
        volume = told[0]["volume"]
        self.assertEqual(volume["dims"], [SIDE] * 3)
        self.assertEqual(volume["spacing"], [1, 1, 2])
        self.assertEqual((volume["low"], volume["high"]), (0, 200))
        self.assertEqual(told[0]["splats"], sum(v >= 90 for v in ball()))
        self.assertIn("kernels", self.done("info", "ball.raw", *self.dims))

    def test_transfer_functions_change_the_picture(self):
        pictures = set()
        self.write("tf.json", json.dumps({"points": [{"value": 100, "opacity": 0},
                                                     {"value": 150, "opacity": 0.2}]}))
        for function in ["auto", "grey", "bone", "flesh", "hot", "tf.json"]:
            self.done("render", "ball.raw", *self.dims, *self.look, "-o", "a.exr",
                      "--transfer-function", function)
            pictures.add(self.read("a.exr"))
        self.done("render", "ball.raw", *self.dims, *self.look, "-o", "a.exr", "--unshaded")
        pictures.add(self.read("a.exr"))
        self.assertEqual(len(pictures), 7)

    def test_a_bound(self):
        self.promises_no_error("ball.raw", *self.dims, "--size", "32x32")

    def test_a_scene_file(self):
        self.write("scene.json", json.dumps({"volume": {"file": "ball.raw", "dims": [SIDE] * 3,
                                                        "transfer_function": "bone"}}))
        self.done("render", "scene.json", *self.look, "-o", "a.exr")
        self.done("render", "ball.raw", *self.dims, *self.look, "-o", "b.exr",
                  "--transfer-function", "bone")
        self.assertEqual(self.read("a.exr"), self.read("b.exr"))

    def test_what_is_refused(self):
        self.fails(3, ["ball.raw", "volume"], "render", "ball.raw", *self.look, "-o", "a.exr")
        self.fails(3, ["bytes"], "render", "ball.raw", *self.look, "-o", "a.exr",
                   "--volume-dims", "9,9,9")
        self.fails(2, ["--volume-dims"], "render", "ball.raw", *self.look, "-o", "a.exr",
                   "--volume-dims", "9,9")
        self.fails(2, ["--volume-spacing"], "render", "ball.raw", *self.look, "-o", "a.exr",
                   "--volume-spacing", "1,0,1")
        self.fails(3, ["no/such"], "render", "ball.raw", *self.dims, *self.look, "-o", "a.exr",
                   "--transfer-function", "no/such.json")
        self.fails(1, ["volume"], "plan", "ball.raw", "--method", "exact", *self.dims)

    def test_a_description_is_no_scene(self):
        one = {"dims": [SIDE] * 3, "dtype": "uint8"}
        for name, content in (("volumes.json", {"ball.raw": one}), ("one.json", one)):
            self.write(name, json.dumps(content))
            self.fails(3, [name, "raw file"], "info", name)
            self.fails(3, [name, "raw file"], "render", name, *self.look, "-o", "a.exr")

    def test_auto_sorts(self):
        told = self.done("plan", "ball.raw", *self.dims)
        self.assertIn("lists: sort", told)
        self.assertIn("axis is chosen: one list, sorted by distance from the eye", told)
        told = self.done("plan", "ball.raw", *self.dims, "--axis-h", "0.9")
        self.assertIn("lists: blend, h 0.9", told)
        self.assertIn("lists: blend, h 0.85", self.done("plan", "ball.raw", *self.dims,
                                                        "--method", "axis"))
        self.assertIn("lists: clip", self.done("plan", "ball.raw", *self.dims,
                                               "--axis-merge", "clip"))


command.main()
