#!/usr/bin/env python3
"""What `ninja install` puts down can be used: the library shows only stp_ symbols, README's example
builds with the pkg-config file and runs, a host in C++ does, the command and the manual page are there.
usage: install.py BUILD CC CXX"""
import glob
import os
import re
import subprocess
import sys
import tempfile

import tree

POINTS = "".join(f"{x} {y} {(x * x + y * y) / 50}\n" for x in range(-9, 10) for y in range(-9, 10))


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


def example():
    """README's block of C as a whole program that checks the version it was built for."""
    block = re.search(r"```c\n(.*?)```", tree.text("README.md"), re.S)[1]
    include, body = block.split("\n", 1)
    return f"{include}\nint main(void)\n{{\n{body}\nreturn stp_version()[0] == 0;\n}}\n"


HOST = """#include <stipple/stipple.h>
#include <stipple/vulkan.h>
int main()
{
    stp_vulkan_features features;
    unsigned count = 0;
    stp_vulkan_wanted_features(nullptr, &features);
    stp_import import = {};
    stp_context *context = nullptr;
    stp_env quiet = {};
    quiet.log = [](void *, stp_log_level, const char *) {};
    return stp_vulkan_feature_list(&count)[0].required && count > 6 &&
                   features.v12.bufferDeviceAddress &&
                   stp_context_import(&quiet, &import, &context) == STP_ERROR_ARGUMENT
               ? 0
               : 1;
}
"""


def host_faults(folder, compiler):
    """A host in C++17, from the installed headers alone."""
    pkgconfig = os.path.dirname(one(folder, "stipple.pc"))
    env = {**os.environ, "PKG_CONFIG_PATH": pkgconfig, "PKG_CONFIG_SYSROOT_DIR": folder}
    flags = run("pkg-config", "--cflags", "--libs", "stipple", env=env).split()
    source, program = os.path.join(folder, "host.cpp"), os.path.join(folder, "host")
    with open(source, "w", encoding="utf-8") as file:
        file.write(HOST)
    run(*compiler.split(), "-std=c++17", "-Wall", "-Wextra", "-Werror", source, "-o", program, *flags)
    env["LD_LIBRARY_PATH"] = os.path.dirname(one(folder, "libstipple.so"))
    if subprocess.run([program], env=env).returncode:
        yield "the host in C++ failed"


def program_faults(folder, compiler):
    """Builds and runs the example in `folder`, on a small scan.ply that is text."""
    pkgconfig = os.path.dirname(one(folder, "stipple.pc"))
    env = {**os.environ, "PKG_CONFIG_PATH": pkgconfig, "PKG_CONFIG_SYSROOT_DIR": folder}
    flags = run("pkg-config", "--cflags", "--libs", "stipple", env=env).split()
    source, program = os.path.join(folder, "use.c"), os.path.join(folder, "use")
    for name, content in [("use.c", example()), ("scan.ply", POINTS)]:
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(content)
    run(*compiler.split(), "-Wall", "-Werror", source, "-o", program, *flags)
    env["LD_LIBRARY_PATH"] = os.path.dirname(one(folder, "libstipple.so"))
    ran = subprocess.run([program], env=env, cwd=folder, capture_output=True, text=True)
    if ran.returncode or not os.path.exists(os.path.join(folder, "scan.exr")):
        yield f"README's example ended with {ran.returncode}: {ran.stderr}"
    if "libstipple.so.0" not in run("readelf", "-d", program):
        yield "the program does not ask for libstipple.so.0"


def main(build, compiler, cxx):
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        run("meson", "install", "-C", build, "--no-rebuild", "--destdir", folder)
        run(one(folder, "bin/stipple"), "--version")
        faults += symbol_faults(os.path.realpath(one(folder, "libstipple.so")))
        faults += program_faults(folder, compiler)
        faults += host_faults(folder, cxx)
        for name in ["stipple.1", "include/stipple/stipple.h"]:
            one(folder, name)
    tree.finish(5, faults)


main(*sys.argv[1:4])
