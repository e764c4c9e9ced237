#!/usr/bin/env python3
"""Each public header compiles alone, as C11 and as C++17.  usage: headers.py CC CXX"""
import os
import subprocess
import sys
import tempfile

import tree

FLAGS = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only",
         "-I" + os.path.join(tree.ROOT, "include")]


def compile_alone(compiler, standard, header, folder, ending):
    source = os.path.join(folder, "alone" + ending)
    with open(source, "w", encoding="utf-8") as file:
        file.write(f"#include <{header}>\n#include <{header}>\nint main(void) {{ return 0; }}\n")
    run = subprocess.run([*compiler, standard, *FLAGS, source], capture_output=True, text=True)
    return [] if run.returncode == 0 else [f"{header} as {standard[5:]}:\n{run.stderr}"]


def main(cc, cxx):
    headers = [os.path.relpath(h, "include") for h in tree.files(".h", folders=["include"])]
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        for header in headers:
            faults += compile_alone(cc.split(), "-std=c11", header, folder, ".c")
            faults += compile_alone(cxx.split(), "-std=c++17", header, folder, ".cpp")
    tree.finish(2 * len(headers), faults)


main(*sys.argv[1:3])
