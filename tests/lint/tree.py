"""What the lints share: the tree's own files, and how a lint ends."""
import os
import re
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
FOLDERS = ["include", "src", "glsl", "tools", "tests", "docs", "assets", ".ci"]
CORPUS = "tests/fuzz/corpus"  # anything at all, on purpose
BINARY = (".ply", ".gz", ".png", ".exr", ".spv", ".pyc")


def files(*endings, folders=None):
    """Paths relative to ROOT, sorted; files beside the folders only when none are named."""
    found = []
    for folder in folders or FOLDERS:
        for at, names, entries in os.walk(os.path.join(ROOT, folder)):
            names[:] = [n for n in names if n != "__pycache__"
                        and os.path.relpath(os.path.join(at, n), ROOT) != CORPUS]
            found += [os.path.relpath(os.path.join(at, e), ROOT) for e in entries]
    if not folders:
        found += [e for e in os.listdir(ROOT)
                  if e != ".git" and os.path.isfile(os.path.join(ROOT, e))]
    found = [f for f in found if not f.endswith(BINARY) and (not endings or f.endswith(endings))]
    return sorted(set(found))


def text(path):
    with open(os.path.join(ROOT, path), encoding="utf-8", errors="replace") as file:
        return file.read()


def includes(path):
    """(line number, name, quoted or in angle brackets)"""
    for number, line in enumerate(text(path).splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line)
        if match:
            yield number, match[2], match[1] == '"'


def code_only(source):
    """Without comments and string literals; lines keep their numbers."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match[0])
    return re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', blank, source, flags=re.S)


def finish(checked, faults):
    """Ends the lint. One that looked at nothing has failed."""
    for fault in faults:
        print(fault)
    print(f"{checked} checked, {len(faults)} at fault")
    sys.exit(1 if faults or not checked else 0)
