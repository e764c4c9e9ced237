#!/usr/bin/env python3
"""A hundred frames in one process do not make its heap grow. What is counted are the bytes in use
when a frame is put into its place (heap.c). Resident memory says less: it is a high-water mark, and
rises by megabytes whenever what threads hold for a while falls together as it never did before."""
import os
import sys

HEAP = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

FRAMES = 100
WINDOW = 20  # frames, of which the least counts: between them a picture may be on its way
# 5 to 9 KB were measured. Of half a kilobyte lost in every frame it would be 35.
MOST = 32 << 10
WAYS = [["--method", "exact"], ["--method", "two-pass", "--path", "raster"],
        ["--method", "reference"]]


class Growth(command.CommandTest):
    def in_use(self, *way):
        """Bytes of the heap after every frame."""
        self.done("render", "ball.ply", "--camera", "path.json", "--frames", "0:%d" % (FRAMES - 1),
                  "-o", "f.%d.exr", "--compression", "none", *way,
                  env={"LD_PRELOAD": HEAP, "HEAP_REPORT": self.path("heap")})
        lines = [line.split(None, 1) for line in self.read("heap").decode().splitlines()]
        heap = [int(size) for size, name in lines if name.endswith(".exr")]  # a driver has files too
        os.unlink(self.path("heap"))
        return heap

    def test_frames(self):
        self.write("ball.ply", command.ply(command.sphere(300)))
        self.done("render", "ball.ply", "--stats", "x.json", "--write-camera", "one.json",
                  "--method", "reference", "--size", "160x120")
        one = self.read("one.json").decode()
        self.write("path.json", "[%s]" % ",".join([one] * FRAMES))
        for way in WAYS:
            with self.subTest(way=way):
                heap = self.in_use(*way)
                self.assertEqual(len(heap), FRAMES)
                self.assertGreater(min(heap), 100000)  # it does count
                self.assertLess(min(heap[-WINDOW:]) - min(heap[10:10 + WINDOW]), MOST)
                first = self.read("f.0.exr")
                self.assertEqual(self.read("f.%d.exr" % (FRAMES - 1)), first)


command.main()
