#!/usr/bin/env python3
"""clang-format would change nothing."""
import subprocess

import tree

PATHS = tree.files(".c", ".h", ".cpp", folders=["include", "src", "tools", "tests"])
RUN = subprocess.run(["clang-format", "--dry-run", "-Werror", "--ferror-limit=3", *PATHS],
                     cwd=tree.ROOT, capture_output=True, text=True)
tree.finish(len(PATHS), [RUN.stderr] if RUN.returncode else [])
