#!/usr/bin/env python3
"""Output that cannot be written, a device that is not there, a run that is cut off: status 1, one
line, the old file whole, and no other file left behind."""
import os
import pty
import resource
import select
import signal
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

REFERENCE = ["--method", "reference", "--size", "64x64"]
LONG = ["--method", "reference", "--size", "1024x1024", "--samples", "1024", "--threads", "1"]


def small_files():
    """Every write beyond 512 bytes fails, as on a full disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))


class Outputs(command.CommandTest):
    def setUp(self):
        super().setUp()
        for name in ["out.exr", "out.png", "out.ply", "out.json"]:
            self.write(name, b"the old file")

    def test_no_such_folder(self):
        for option in ["-o", "--preview", "--stats", "--write-camera"]:
            path = {"-o": "no/x.exr", "--preview": "no/x.png"}.get(option, "no/x.json")
            output = [] if option == "-o" else ["-o", "out.exr"]
            self.fails(1, [path, "No such file"], "render", "ball.ply", *output, option, path,
                       *REFERENCE)
        self.fails(1, ["no/x.ply"], "prepare", "ball.ply", "-o", "no/x.ply")

    def test_found_before_reading(self):
        self.fails(1, ["no/x.exr"], "render", "missing.ply", "-o", "no/x.exr", *REFERENCE)

    def test_not_over_the_input(self):
        os.link(self.path("ball.ply"), self.path("same.ply"))
        self.fails(1, ["same.ply", "input"], "prepare", "ball.ply", "-o", "same.ply")

    def test_not_over_a_folder(self):
        os.mkdir(self.path("folder.exr"))
        self.fails(1, ["folder.exr"], "render", "ball.ply", "-o", "folder.exr", *REFERENCE)

    def test_full_disk(self):
        full = {"preexec_fn": small_files, "restore_signals": False}
        self.fails(1, ["out.exr"], "render", "ball.ply", "-o", "out.exr", *REFERENCE, **full)
        self.fails(1, ["out.png"], "render", "ball.ply", "--preview", "out.png", *REFERENCE,
                   **full)
        self.fails(1, ["out.json"], "render", "ball.ply", "--stats", "out.json", *REFERENCE,
                   **full)
        self.fails(1, ["out.ply"], "prepare", "ball.ply", "-o", "out.ply", **full)

    def test_full_standard_output(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            run = subprocess.run([command.TOOL, "info", "ball.ply"], cwd=self.folder, stdout=full,
                                 stderr=subprocess.PIPE, text=True, timeout=60)
        self.assertEqual(run.returncode, 1)
        self.assertIn("standard output", run.stderr)

    def test_closed_standard_output(self):
        run = subprocess.run([command.TOOL, "info", "ball.ply"], cwd=self.folder, timeout=60,
                             stderr=subprocess.PIPE, text=True,
                             preexec_fn=lambda: os.close(1))
        self.assertEqual(run.returncode, 1)
        self.assertIn("standard output", run.stderr)
        run = subprocess.run([command.TOOL, "render", "ball.ply", "-o", "out.exr", *REFERENCE],
                             cwd=self.folder, timeout=60, preexec_fn=lambda: os.closerange(0, 3))
        self.assertEqual(run.returncode, 0)
        self.assertEqual(self.read("out.exr")[:4], b"v/1\x01")

    def test_odd_environment(self):
        self.done("render", "ball.ply", "-o", "plain.exr", *REFERENCE)
        for name, value in [("LC_ALL", "de_DE.UTF-8"), ("LC_ALL", "no such"), ("TERM", ""),
                            ("HOME", ""), ("TMPDIR", "/nonexistent"), ("COLUMNS", "0"),
                            ("MALLOC_PERTURB_", "165")]:
            self.done("render", "ball.ply", "-o", "out.exr", *REFERENCE, env={name: value})
            self.assertEqual(self.read("out.exr"), self.read("plain.exr"), name)

    def test_signals(self):
        """Without a terminal, on a device too; the old files stay and no other is left."""
        before = self.listing()
        for number, method in [(signal.SIGINT, LONG), (signal.SIGTERM, LONG),
                               (signal.SIGTERM, ["--samples", "4096", "--size", "1024x1024"])]:
            process = subprocess.Popen([command.TOOL, "render", "ball.ply", "-o", "out.exr",
                                        "--preview", "out.png", *method], cwd=self.folder)
            with self.assertRaises(subprocess.TimeoutExpired):
                process.wait(0.7)
            process.send_signal(number)
            self.assertEqual(process.wait(60), -number)
            self.assertEqual(self.listing(), before)

    def test_no_device(self):
        none = {"VK_ICD_FILENAMES": "/nonexistent.json", "VK_DRIVER_FILES": "/nonexistent.json"}
        self.fails(1, ["Vulkan", "mesa-vulkan-drivers", "--method reference"], "render",
                   "ball.ply", "-o", "out.exr", env=none)
        self.fails(1, ["Vulkan", "mesa-vulkan-drivers"], "devices", env=none)
        self.done("render", "ball.ply", "-o", "out.exr", *REFERENCE, env=none)

    def test_no_such_device(self):
        self.fails(1, ["Abacus"], "render", "ball.ply", "-o", "out.exr", "--device", "Abacus")
        self.fails(1, ["Abacus"], "devices", "--device", "Abacus")

    def test_interrupt(self):
        before = self.listing()
        terminal, end = pty.openpty()
        process = subprocess.Popen([command.TOOL, "render", "ball.ply", "-o", "out.exr", *LONG],
                                   cwd=self.folder, stderr=end,
                                   env={**os.environ, "TERM": "xterm"})
        os.close(end)
        self.assertTrue(select.select([terminal], [], [], 60)[0], "no progress bar was drawn")
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(60), -signal.SIGINT)
        os.close(terminal)
        self.assertEqual(self.listing(), before)


command.main()
