#!/usr/bin/env python3
"""Every file of this tree that a text or a comment names is there; so is every function that a document
places: `path:function`, `path`: `function`, `function` in `path`, each with more names or without."""
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


CODE = tree.files(".c", ".h", ".cpp", ".py", ".glsl", ".comp", ".vert", ".frag")
FILE = r"`?([\w./-]+\.(?:c|h|cpp|py|glsl|comp|vert|frag))"
NAMES = r"([A-Za-z_]\w*(?:`,\s+`[a-z]\w*)*)`"
PLACED = [re.compile(FILE + ":" + NAMES), re.compile(FILE + r"`:\s`" + NAMES)]
PLACED_IN = re.compile("`" + NAMES + r"\s+in\s+" + FILE + "`")


def is_function(path, name):
    """A definition, declaration or macro: the name, before a parenthesis, not within a comment."""
    source = tree.text(path)
    source = re.sub(r"#[^\n]*", "", source) if path.endswith(".py") else tree.code_only(source)
    start = r"\s*def\s+" if path.endswith(".py") else r"(?:[\w#][^\n;=(]*[\s*])?"
    return re.search(rf"^{start}{name}\(", source, re.M)


def placed(source):
    """(where, file, functions)"""
    for pattern in PLACED:
        yield from ((m.start(), m[1], m[2]) for m in pattern.finditer(source))
    yield from ((m.start(), m[2], m[1]) for m in PLACED_IN.finditer(source))


def check_functions(path):
    """The path may leave out leading folders."""
    source = tree.text(path)
    for at, file, functions in placed(source):
        number = source.count("\n", 0, at) + 1
        files = [f for f in CODE if ("/" + f).endswith("/" + file)]
        if not files:
            yield f"{path}:{number}: names {file}"
        for name in re.findall(r"\w+", functions):
            if files and not any(is_function(f, name) for f in files):
                yield f"{path}:{number}: no function {name} in {file}"


DOCUMENTS = tree.files(".md")
PATHS = tree.files(".md", ".h", ".c", ".cpp", ".1", ".py", ".glsl", ".comp", ".vert", ".frag")
tree.finish(len(PATHS), [fault for path in PATHS for fault in check(path)]
            + [fault for path in DOCUMENTS for fault in check_functions(path)])
