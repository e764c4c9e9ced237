#!/usr/bin/env python3
"""Every program of tools in Python says what it does, and of wrong arguments one line."""
import os
import subprocess
import sys

import tree

SHARED = {"tools/command_line.py"}
COUNTS = "tools/count_tests.py"  # of which a log that is not there is a test that failed


def result(path, *arguments):
    return subprocess.run([sys.executable, "-B", os.path.join(tree.ROOT, path), *arguments],
                          capture_output=True, text=True, timeout=60)


def check(path):
    if not os.access(os.path.join(tree.ROOT, path), os.X_OK):
        yield f"{path}: not executable"
    said = result(path, "--help")
    if said.returncode != 0 or "usage: " not in said.stdout or said.stderr:
        yield f"{path} --help: status {said.returncode}: {said.stdout + said.stderr}"
    for wrong in (["--no-such-option"], [] if path == COUNTS else ["no-such-file"] * 9):
        said = result(path, *wrong)
        if said.returncode != 2 or said.stdout or len(said.stderr.splitlines()) != 1:
            yield f"{path} {' '.join(wrong)}: status {said.returncode}: {said.stdout + said.stderr}"


PATHS = [path for path in tree.files(".py", folders=["tools"])
         if path not in SHARED and os.path.dirname(path) == "tools"]
tree.finish(len(PATHS), [fault for path in PATHS for fault in check(path)])
