#!/usr/bin/env python3
"""What `ninja install` puts down can be used: the library shows only stp_ symbols, a program
builds with its pkg-config file and runs, the command and the manual page are there.
usage: install.py BUILD CC"""
import glob
import os
import subprocess
import sys
import tempfile

import tree

PROGRAM = """#include <stipple/stipple.h>
#include <string.h>
int main(void) { return strcmp(stp_version(), "%s") != 0; }
"""


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=True, **more).stdout


def one(folder, pattern):
    found = glob.glob(os.path.join(folder, "**", pattern), recursive=True)
    if not found:
        raise FileNotFoundError(f"nothing installed matches {pattern}")
    return found[0]


def symbol_faults(library):
    names = [line.split()[-1] for line in run("nm", "-D", "--defined-only", library).splitlines()]
    if not any(name == "stp_version" for name in names):
        yield "libstipple.so does not show stp_version"
    for name in names:
        if not name.startswith("stp_"):
            yield f"libstipple.so shows {name}"


def program_faults(folder, prefix, compiler, version):
    library = one(folder, "libstipple.so")
    pkgconfig = os.path.dirname(one(folder, "stipple.pc"))
    env = {**os.environ, "PKG_CONFIG_PATH": pkgconfig, "PKG_CONFIG_SYSROOT_DIR": folder}
    flags = run("pkg-config", "--cflags", "--libs", "stipple", env=env).split()
    source, program = os.path.join(folder, "use.c"), os.path.join(folder, "use")
    with open(source, "w", encoding="utf-8") as file:
        file.write(PROGRAM % version)
    run(*compiler.split(), source, "-o", program, *flags)
    env["LD_LIBRARY_PATH"] = os.path.dirname(library)
    if subprocess.run([program], env=env).returncode:
        yield "the program built against the installed library failed"
    if "libstipple.so.0" not in run("readelf", "-d", program):
        yield "the program does not ask for libstipple.so.0"


def main(build, compiler):
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        run("meson", "install", "-C", build, "--no-rebuild", "--destdir", folder)
        command = one(folder, "bin/stipple")
        version = run(command, "--version").split()[1]
        faults += symbol_faults(os.path.realpath(one(folder, "libstipple.so")))
        faults += program_faults(folder, build, compiler, version)
        for name in ["stipple.1", "include/stipple/stipple.h"]:
            one(folder, name)
    tree.finish(4, faults)


main(*sys.argv[1:3])
