#!/usr/bin/env python3
"""A stage includes only from itself and from stages before it; only gpu, passes and record name Vulkan.
Every shader is compiled, and every file that shaders include makes them anew when it changes."""
import os
import re

import tree

STAGES = ["base", "load", "scene", "prepare", "reference", "write", "report", "plan", "gpu",
          "passes", "record", "study"]
VULKAN = {"gpu", "passes", "record"}
# Stages that stand on the scene alone: they measure or store what others made.
APART = {"reference": {"base", "load", "scene"}, "write": {"base", "load", "scene"},
         "report": {"base", "load", "scene"}}
# What a stage may never see although it comes earlier.
HIDDEN = {"passes": {"load", "scene", "prepare", "reference", "write", "report"}}
NAMES_VULKAN = re.compile(r"\bvk[A-Z]\w+|\bVk[A-Z]\w+|\bVK_[A-Z]\w+|\bvolk[A-Z]\w+")


def allowed(stage):
    before = set(STAGES[:STAGES.index(stage)])
    return (APART.get(stage, before) - HIDDEN.get(stage, set())) | {stage}


def check_stage_file(path, stage):
    for number, name, quoted in tree.includes(path):
        where = f"{path}:{number}"
        if name.startswith(("vulkan/", "volk")) or name == "stipple/vulkan.h":
            if stage not in VULKAN:
                yield f"{where}: {stage} includes {name}"
        elif not quoted:
            continue
        elif "/" not in name:
            made = os.path.join(tree.ROOT, "src", stage, name + ".in")
            if not os.path.exists(made):  # else the build makes it
                yield f"{where}: \"{name}\" names no stage; write \"{stage}/{name}\""
        elif name.startswith("shared/"):
            if stage not in VULKAN | {"plan"}:
                yield f"{where}: {stage} includes what the shaders share, {name}"
        elif name.split("/")[0] not in allowed(stage):
            yield f"{where}: {stage} may not include {name}"


def check_tool_file(path):
    for number, name, quoted in tree.includes(path):
        beside = os.path.join(tree.ROOT, os.path.dirname(path), name)
        made = path.startswith("tools/viewer") and name.startswith("plane_")  # from its shaders
        if quoted and ("/" in name or not (made or os.path.exists(beside))):
            yield f"{path}:{number}: a tool includes only public headers, not {name}"


def check_public_header(path):
    for number, name, quoted in tree.includes(path):
        if quoted or (name.startswith("vulkan/") and not path.endswith("/vulkan.h")):
            yield f"{path}:{number}: a public header may not include {name}"


def check_vulkan_names(path):
    for number, line in enumerate(tree.code_only(tree.text(path)).splitlines(), 1):
        match = NAMES_VULKAN.search(line)
        if match:
            yield f"{path}:{number}: names Vulkan: {match[0]}"


def check(path):
    parts = path.split(os.sep)
    if parts[0] == "src":
        yield from check_stage_file(path, parts[1])
    elif parts[0] == "tools":
        yield from check_tool_file(path)
    elif parts[0] == "include":
        yield from check_public_header(path)
    free = (path == "include/stipple/vulkan.h" or path.startswith("tools/viewer/") or
            (parts[0] == "src" and parts[1] in VULKAN))
    if not free:
        yield from check_vulkan_names(path)


def check_shader(path):
    name = os.path.basename(path)
    if path.startswith("glsl/lib/") or path.startswith("glsl/shared/"):
        name = os.path.splitext(name)[0]
    if f"'{name}'" not in tree.text("src/passes/meson.build"):
        yield f"{path}: not named in src/passes/meson.build"


SHADERS = tree.files(folders=["glsl"])
PATHS = tree.files(".c", ".h", ".cpp", folders=["src", "tools", "include"])
tree.finish(len(PATHS), [fault for path in PATHS for fault in check(path)]
            + [fault for path in SHADERS for fault in check_shader(path)])
