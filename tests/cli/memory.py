#!/usr/bin/env python3
"""No leak and no invalid access under valgrind, on success and on failure. The methods that use a
Vulkan device are left to the sanitizers: drivers leak."""
import os
import subprocess

import command

VALGRIND = ["valgrind", "-q", "--leak-check=full", "--errors-for-leak-kinds=definite,indirect",
            "--error-exitcode=99"]
RENDER = ["render", "ball.ply", "-o", "a.exr", "--method", "reference", "--size", "16x16"]


class Memory(command.CommandTest):
    def clean(self, status, *arguments):
        run = subprocess.run([*VALGRIND, command.TOOL, *arguments], cwd=self.folder, timeout=150,
                             capture_output=True, text=True,
                             env={**os.environ, "MALLOC_PERTURB_": "0"})
        self.assertEqual(run.returncode, status, (arguments, run.stderr))
        self.assertNotIn("==", run.stderr)

    def setUp(self):
        super().setUp()
        self.write("ball.ply", command.ply(command.sphere(200)))

    def test_done(self):
        self.clean(0, *RENDER, "--preview", "a.png", "--stats", "a.json", "--write-camera",
                   "c.json", "--aov", "albedo,id")
        self.clean(0, "compare", "a.exr", "a.exr", "--json")
        self.clean(0, "prepare", "ball.ply", "-o", "out.ply", "--group")
        self.clean(0, "plan", "ball.ply", "--method", "deferred")
        self.clean(0, "info", "ball.ply", "--json")

    def test_failed(self):
        self.write("short.ply", self.read("ball.ply")[:-1])
        self.clean(2, *RENDER, "--samples", "0")
        self.clean(3, "render", "short.ply", "-o", "a.exr", "--method", "reference")
        self.clean(3, *RENDER, "--camera", "missing.json")
        self.clean(1, "prepare", "ball.ply", "-o", "no/out.ply")


command.main()
