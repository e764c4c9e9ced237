#!/usr/bin/env python3
"""clang-format would change nothing, and no comment is a ruler between sections: a file in sections is
two files, or needs no more than its functions' names."""
import re
import subprocess

import tree

PATHS = tree.files(".c", ".h", ".cpp", folders=["include", "src", "tools", "tests"])
RUN = subprocess.run(["clang-format", "--dry-run", "-Werror", "--ferror-limit=3", *PATHS],
                     cwd=tree.ROOT, capture_output=True, text=True)
FAULTS = [RUN.stderr] if RUN.returncode else []
RULER = re.compile(r"^\s*(?:/\*|//|#|\*)\s*(?:[^*]*\s)?[-=*#~]{3,}(?:\s|$)")
RULED = tree.files(".c", ".h", ".cpp", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh", "meson.build")
for path in RULED:
    FAULTS += [f"{path}:{number}: a ruler" for number, line
               in enumerate(tree.text(path).splitlines(), 1) if RULER.match(line)]
tree.finish(len(RULED), FAULTS)
