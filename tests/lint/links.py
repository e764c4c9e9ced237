#!/usr/bin/env python3
"""Every file of this tree that a text or a comment names is there."""
import os
import re

import tree

NAMED = re.compile(r"(?<![\w/.-])(?:docs|assets|glsl|src|tools|tests|include)/[\w./-]*\.\w+")
RESERVED = {"include/stipple/vulkan.h"}  # layers.py keeps the name for the one header it is for


def check(path):
    for number, line in enumerate(tree.text(path).splitlines(), 1):
        for match in NAMED.finditer(line):
            if not os.path.exists(os.path.join(tree.ROOT, match[0])) and match[0] not in RESERVED:
                yield f"{path}:{number}: names {match[0]}"


PATHS = tree.files(".md", ".h", ".c", ".cpp", ".1", ".py", ".glsl", ".comp", ".vert", ".frag")
tree.finish(len(PATHS), [fault for path in PATHS for fault in check(path)])
