#!/usr/bin/env python3
"""Opacity from files, scenes and the command line, to pictures and back into files."""
import json
import re
import struct
import subprocess

import command

BASIC = ["--size", "40x30", "--view", "front", "--transparency", "reference"]


def ply(points, opacities):
    """Binary PLY with a uchar alpha."""
    names = "".join("property float %s\n" % name for name in "x y z nx ny nz".split())
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n%sproperty uchar alpha\n"
              "end_header\n" % (len(points), names))
    return header.encode() + b"".join(struct.pack("<6fB", *p, *p, a)
                                      for p, a in zip(points, opacities))


class Transparency(command.CommandTest):
    def picture(self, scene, *options):
        self.done("render", scene, "-o", "out.exr", *BASIC, *options)
        return self.read("out.exr")

    def centre(self, channels="R,G,B,A"):
        chosen = self.path("chosen.exr")
        subprocess.run(["oiiotool", self.path("out.exr"), "--ch", channels, "-o", chosen],
                       check=True)
        run = subprocess.run(["oiiotool", "--dumpdata", chosen], capture_output=True, text=True,
                             check=True)
        values = re.search(r"Pixel \(20, 15\): ([-\d.infe+ ]+)", run.stdout)[1]
        return [float(v) for v in values.split()]

    def test_two_sides_of_a_ball(self):
        """Behind the front of 0.5 lies the back, seen from inside."""
        self.picture("ball.ply", "--opacity", "0.5", "--aov", "layers", "--cull", "none")
        self.assertAlmostEqual(self.centre()[3], 0.75, 6)
        self.assertEqual(self.centre("layers"), [2])
        self.picture("ball.ply", "--opacity", "0.5", "--cull", "back")
        self.assertAlmostEqual(self.centre()[3], 0.5, 6)

    def test_stats(self):
        """Where --aov counts them: two sides of a ball."""
        self.done("render", "ball.ply", "--stats", "s.json", *BASIC, "--opacity", "0.5", "--cull",
                  "none", "--aov", "layers,fragments")
        stats = json.loads(self.read("s.json"))
        self.assertGreaterEqual(stats["layers"]["max"], 2)
        self.assertGreater(stats["layers"]["mean"], 1.5)
        self.assertLessEqual(stats["layers"]["mean"], stats["layers"]["max"])
        self.assertGreaterEqual(stats["fragments"]["max"], stats["fragments"]["mean"])
        self.done("render", "ball.ply", "--stats", "s.json", *BASIC, "--opacity", "0.5")
        self.assertNotIn("layers", json.loads(self.read("s.json")))

    def test_from_the_file(self):
        self.write("glass.ply", ply(command.sphere(), [51] * 2000))
        facts = self.done_json("info", "--json", "glass.ply")[0]
        self.assertEqual((facts["transparent"], facts["mixed"], facts["uniform_opacity"]),
                         (True, False, True))
        self.assertAlmostEqual(facts["opacity_min"], 0.2, 6)
        self.assertIn("transparent, from 0.2", self.done("info", "glass.ply"))
        self.picture("glass.ply", "--cull", "back")
        self.assertAlmostEqual(self.centre()[3], 0.2, 6)
        self.picture("glass.ply", "--cull", "back", "--opacity", "0.5")
        self.assertAlmostEqual(self.centre()[3], 0.1, 6)

    def test_invisible(self):
        self.picture("ball.ply", "--opacity", "0")
        self.assertEqual(self.centre(), [0, 0, 0, 0])
        self.picture("ball.ply", "--opacity", "1")
        self.assertEqual(self.centre()[3], 1)

    def test_opaque_pictures_do_not_change(self):
        self.done("render", "ball.ply", "-o", "out.exr", *BASIC[:4], "--method", "reference")
        opaque = self.read("out.exr")
        self.write("full.ply", ply(command.sphere(), [255] * 2000))
        self.assertEqual(self.picture("full.ply", "--opacity", "1", "--method", "reference"),
                         opaque)

    def test_scene(self):
        """The material's and the object's multiply; the command line takes the object's place."""
        entry = {"file": "ball.ply", "opacity": 0.5, "material": {"opacity": 0.25}}
        self.write("s.json", json.dumps({"points": [entry]}))
        self.picture("s.json", "--cull", "back")
        self.assertAlmostEqual(self.centre()[3], 0.125, 6)
        self.picture("s.json", "--cull", "back", "--opacity", "1")
        self.assertAlmostEqual(self.centre()[3], 0.25, 6)

    def test_prepared(self):
        self.write("glass.ply", ply(command.sphere(), [i % 256 for i in range(2000)]))
        self.done("prepare", "glass.ply", "-o", "p.ply", "--opacity", "0.5")
        self.assertIn(b"property float opacity\n", self.read("p.ply"))
        direct = self.picture("glass.ply", "--opacity", "0.5")
        self.assertEqual(self.picture("p.ply"), direct)

    def test_method_and_transparency_must_agree(self):
        self.fails(1, ["method two-pass", "exact"], "render", "ball.ply", "-o", "out.exr",
                   "--opacity", "0.5", "--method", "two-pass", "--transparency", "exact")


command.main()
