#!/usr/bin/env python3
"""Devices that cannot do it: too little memory, features that are missing, drivers and layers that
are not there; and output and input that fail when a device renders. One line, the right status,
the old output whole, nothing else left behind."""
import json
import os
import resource
import shutil
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

RENDER = ["render", "ball.ply", "-o", "out.exr", "--size", "64x64"]


def small_files():
    """Every write beyond 4096 bytes fails, as on a disk that fills up."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))


class Device(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.write("out.exr", b"the old file")

    def test_too_little_memory(self):
        self.fails(1, ["tile"], *RENDER, "--tile-memory", "1K")
        self.fails(1, ["tile"], "plan", "ball.ply", "--tile-memory", "1K")

    def test_a_small_device(self):
        profile = json.loads(self.done("devices", "--json"))
        profile = profile[0] if isinstance(profile, list) else profile
        profile["heap_bytes"] = 50000
        self.write("limits.json", json.dumps(profile))
        small = ["plan", "ball.ply", "--limits", "limits.json"]
        self.fails(1, ["50000 bytes"], *small, "--method", "two-pass")
        self.assertIn("reference is chosen", self.done(*small))

    def test_missing_features(self):
        self.fails(1, ["shaderInt64"], *RENDER, "--mask-feature", "int64")
        self.fails(1, ["shaderBufferInt64Atomics", "--path raster"], *RENDER, "--method",
                   "deferred", "--path", "compute", "--mask-feature", "int64-atomics")
        self.fails(1, ["blending", "--path compute"], *RENDER, "--method", "two-pass", "--path",
                   "raster", "--mask-feature", "float32-blend")

    def test_what_no_method_offers(self):
        for line in [["--method", "exact", "--path", "raster"],
                     ["--method", "deferred", "--path", "raster", "--voronoi", "exact"]]:
            run = self.run_tool(*RENDER, *line)
            self.assertIn(run.returncode, (1, 2), line)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            self.assertEqual(self.read("out.exr"), b"the old file")

    def test_a_driver_that_is_gone(self):
        self.write("icd.json", json.dumps({"file_format_version": "1.0.0", "ICD": {
            "library_path": "/nonexistent/libvulkan_none.so", "api_version": "1.3.0"}}))
        icd = self.path("icd.json")
        self.fails(1, ["Vulkan"], *RENDER, env={"VK_ICD_FILENAMES": icd, "VK_DRIVER_FILES": icd})

    def test_no_validation_layer(self):
        none = {"VK_LAYER_PATH": self.folder}
        self.fails(1, ["VK_LAYER_KHRONOS_validation", "vulkan-validationlayers"], *RENDER,
                   "--validate", env=none)

    def test_full_disk(self):
        cache = {"MESA_SHADER_CACHE_DISABLE": "true"}  # it would fill up too
        for more in [[], ["--compression", "none"], ["--preview", "out.png"]]:
            self.fails(1, ["out.exr"], *RENDER, "--size", "256x256", *more, env=cache,
                       preexec_fn=small_files, restore_signals=False)

    def test_a_folder_that_cannot_be_written(self):
        tool = os.path.join(self.folder, "stipple")
        shutil.copy(command.TOOL, tool)
        os.chmod(tool, 0o755)
        os.chmod(self.path("ball.ply"), 0o644)
        os.chmod(self.path("out.exr"), 0o444)
        os.chmod(self.folder, 0o555)
        user = 65534 if os.getuid() == 0 else None
        more = {"user": user, "group": user, "extra_groups": []} if user else {}
        old, command.TOOL = command.TOOL, tool
        try:
            self.fails(1, ["out.exr", "ermission denied"], *RENDER, **more)
        finally:
            command.TOOL = old
            os.chmod(self.folder, 0o755)

    def test_truncated_inputs(self):
        ball = command.ply(command.sphere(200))
        header = ball.index(b"end_header")
        for size in [0, 1, 3, 4, 20, header - 1, header + 5, header + 11, header + 12,
                     len(ball) // 2, len(ball) - 24, len(ball) - 1]:
            with self.subTest(size=size):
                self.write("cut.ply", ball[:size])
                self.fails(3, ["cut.ply"], "render", "cut.ply", "-o", "out.exr", "--size", "8x8")


command.main()
