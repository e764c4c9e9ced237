#!/usr/bin/env python3
"""A hundred frames in one process do not make it grow."""
import json
import os
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

FRAMES = 100
# A leak of a page a frame shows in every frame. What the allocator and the driver keep grows in few
# steps of some megabytes; a picture lost in every frame would be 62 of them.
STEPS = 20 << 20  # bytes between the tenth frame and the last
WAYS = [["--method", "exact"], ["--method", "reference"]]  # pass_memory has them all


class Growth(command.CommandTest):
    def test_frames(self):
        self.write("ball.ply", command.ply(command.sphere(300)))
        self.done("render", "ball.ply", "--stats", "x.json", "--write-camera", "one.json",
                  "--method", "reference", "--size", "160x120")
        one = self.read("one.json").decode()
        self.write("path.json", "[%s]" % ",".join([one] * FRAMES))
        for way in WAYS:
            with self.subTest(way=way):
                self.done("render", "ball.ply", "--camera", "path.json", "--frames",
                          "0:%d" % (FRAMES - 1), "-o", "f.%d.exr", "--compression", "none",
                          "--stats", "s.json", *way)
                resident = [frame["peak_rss"] for frame in json.loads(self.read("s.json"))]
                self.assertEqual(len(resident), FRAMES)
                growth = [b - a for a, b in zip(resident[9:], resident[10:])]
                self.assertEqual(statistics.median(growth), 0)
                self.assertLess(sum(growth), STEPS)
                first = self.read("f.0.exr")
                self.assertEqual(self.read("f.%d.exr" % (FRAMES - 1)), first)


command.main()
