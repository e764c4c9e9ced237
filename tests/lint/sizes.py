#!/usr/bin/env python3
"""Files stay under 600 lines, functions of C under 60, and nothing large is committed."""
import os
import re

import tree

SOURCES = (".c", ".h", ".cpp", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh")
LARGEST = {"assets": 3 << 20}  # bytes; elsewhere 1 MiB


def long_functions(path, lines):
    start = None
    for number, line in enumerate(lines, 1):
        if line == "{":
            start = number
        elif line == "}" and start:
            if number - start - 1 > 60:
                yield f"{path}:{start}: a function of {number - start - 1} lines"
            start = None


def check_source(path):
    lines = tree.text(path).splitlines()
    if len(lines) > 600:
        yield f"{path}: {len(lines)} lines"
    if re.search(r"\.(c|cpp)$", path):
        yield from long_functions(path, lines)


def check_bytes():
    for folder in tree.FOLDERS:
        for at, _, names in os.walk(os.path.join(tree.ROOT, folder)):
            for name in names:
                path = os.path.join(at, name)
                if os.path.getsize(path) > LARGEST.get(folder, 1 << 20):
                    yield f"{os.path.relpath(path, tree.ROOT)}: {os.path.getsize(path)} bytes"


PATHS = tree.files(*SOURCES)
tree.finish(len(PATHS), [f for path in PATHS for f in check_source(path)] + list(check_bytes()))
