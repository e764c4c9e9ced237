"""Runs the command on small inputs made here. Every test of tests/cli and tests/fail is a unittest
whose first argument is the command's path."""
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

TOOL = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else "stipple"


def sphere(count=2000, radius=1.0):
    """(x, y, z) on a sphere that every renderer closes."""
    points = []
    for i in range(count):
        z = 1 - (2 * i + 1) / count
        ring, angle = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
        points.append((radius * ring * math.cos(angle), radius * ring * math.sin(angle),
                       radius * z))
    return points


def ply(points, claimed=None):
    """Binary PLY of positions and normals; `claimed` lies about the count."""
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n" %
              (len(points) if claimed is None else claimed))
    header += "".join("property float %s\n" % name for name in "x y z nx ny nz".split())
    body = b"".join(struct.pack("<6f", *p, *p) for p in points)
    return header.encode() + b"end_header\n" + body


class CommandTest(unittest.TestCase):
    """A folder for each test, with ball.ply in it; the command runs in that folder."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="stipple-test-")
        os.chmod(self.folder, 0o755)
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.cache = tempfile.mkdtemp(prefix="stipple-cache-")  # not the user's
        self.addCleanup(shutil.rmtree, self.cache, ignore_errors=True)
        self.write("ball.ply", ply(sphere()))

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, content):
        with open(self.path(name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def run_tool(self, *arguments, env=None, **more):
        return subprocess.run([TOOL, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=120, **more,
                              env={**os.environ, "XDG_CACHE_HOME": self.cache, **(env or {})})

    def done(self, *arguments, **more):
        """Runs; must succeed and say nothing on stderr. Returns stdout."""
        run = self.run_tool(*arguments, **more)
        self.assertEqual((run.returncode, run.stderr), (0, ""), arguments)
        return run.stdout

    def done_json(self, *arguments):
        return json.loads(self.done(*arguments))

    def fails(self, status, words, *arguments, **more):
        """Runs; must end with `status`, one line on stderr that holds every word, and no change
        in the folder. Returns the line."""
        before = self.listing()
        run = self.run_tool(*arguments, **more)
        self.assertEqual(run.returncode, status, (arguments, run.stderr))
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertTrue(run.stderr.startswith("stipple: "), run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertEqual(self.listing(), before, "files appeared, vanished or changed")
        return run.stderr

    def promises_no_error(self, *scene):
        """--max-error: one warning, the picture of no bound, and no device is calibrated for it."""
        self.done("render", *scene, "-o", "free.exr")
        run = self.run_tool("render", *scene, "-o", "bound.exr", "--max-error", "1e-3")
        self.assertEqual((run.returncode, run.stderr), (
            0, "stipple: warning: the error of volumes and range images is not estimated: the bound "
               "of 0.001 is not looked at\n"))
        self.assertEqual(self.read("free.exr"), self.read("bound.exr"))
        self.assertFalse(os.path.exists(os.path.join(self.cache, "stipple")))

    def listing(self):
        return {name: os.path.isfile(self.path(name)) and os.access(self.path(name), os.R_OK)
                and self.read(name) for name in os.listdir(self.folder)}


def main():
    unittest.main(verbosity=1)
