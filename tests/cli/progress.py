#!/usr/bin/env python3
"""The progress bar: on a terminal, after a second, as wide as the terminal, erased at the end;
never in a pipe, with --quiet or on a dumb terminal."""
import fcntl
import os
import pty
import struct
import subprocess
import termios
import time

import command

ERASE = b"\r\033[K"
SLOW = ["render", "ball.ply", "-o", "out.exr", "--method", "reference", "--size", "1024x1024",
        "--samples", "4", "--threads", "1", "--compression", "none"]


class Progress(command.CommandTest):
    def on_terminal(self, arguments, columns, name="xterm"):
        """What arrives at a terminal of that width, and the seconds it took."""
        terminal, end = pty.openpty()
        fcntl.ioctl(end, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
        start = time.monotonic()
        process = subprocess.Popen([command.TOOL, *arguments], cwd=self.folder, stderr=end,
                                   env={**os.environ, "TERM": name})
        os.close(end)
        output = b""
        while True:
            try:
                part = os.read(terminal, 65536)
            except OSError:  # the other end is closed
                break
            output += part
        os.close(terminal)
        self.assertEqual(process.wait(), 0)
        return output, time.monotonic() - start

    def test_bar(self):
        for columns in [100, 40]:
            output, seconds = self.on_terminal(SLOW, columns)
            frames = output.split(ERASE)
            self.assertGreater(len(frames), 2, f"no bar in {seconds:.1f} s")
            self.assertEqual((frames[0], frames[-1]), (b"", b""), "it is erased at the end")
            for frame in frames[1:-1]:
                self.assertLess(len(frame), columns)
                self.assertRegex(frame, rb"^[\w ]{12}\[=*>? *\] +\d+ %$")
            self.assertLess(len(frames), 10 * seconds + 3, "at most ten a second")

    def test_no_bar(self):
        self.assertEqual(self.on_terminal([*SLOW, "--quiet"], 80)[0], b"")
        self.assertEqual(self.on_terminal(SLOW, 80, "dumb")[0], b"")
        quick = [*SLOW[:6], "--size", "16x16"]
        self.assertEqual(self.on_terminal(quick, 80)[0], b"")
        self.done(*SLOW)  # through a pipe: nothing on stderr


command.main()
