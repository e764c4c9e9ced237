#!/usr/bin/env python3
"""Hofsetz and Max's tables on volumes of your own, as Markdown.

  tools/bench_axis.py tables FILE... [--view AZ,EL] [--rounds N]   splats, times and errors
  tools/bench_axis.py popping FILE... [--view AZ,EL --to AZ,EL --frames N]

tables: splats drawn, the median of warm frames (interleaved over rounds), and the PSNR over covered
pixels against the exact order of the float64 reference; 512 x 512, as in the paper. popping: the
largest RMSE between neighbouring frames of a path from --view to --to, 256 x 256, of every merge and
of the exact order itself. docs/results/axis.md was made with it.
"""
import argparse
import json
import math
import os
import re
import statistics
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
STIPPLE = os.path.join(ROOT, "build", "tools", "stipple")
CONFIGS = [
    ("blend, h = 0", ["--axis-merge", "blend", "--axis-h", "0"]),
    ("blend, h = 0.85", ["--axis-merge", "blend"]),
    ("blend, h = 0.95", ["--axis-merge", "blend", "--axis-h", "0.95"]),
    ("clip", ["--axis-merge", "clip"]),
    ("single", ["--axis-merge", "single"]),
    ("sort", ["--axis-merge", "sort"]),
]


def run(*arguments):
    return subprocess.run([STIPPLE, *arguments], check=True, capture_output=True, text=True).stdout


def render(file, view, size, out, more, stats=None, repeat=0):
    timing = ["--stats", stats, "--repeat", str(repeat)] if stats else []
    run("render", file, "--size", f"{size}x{size}", "--view", view, "-o", out, "-q",
        "--compression", "none", *more, *timing)


def error(a, b):
    """The figures over all pixels and over covered ones, of a against b."""
    return json.loads(run("compare", "--json", a, b))


def one_table(file, view, rounds, folder):
    truth, out, stats = (os.path.join(folder, n) for n in ("truth.exr", "out.exr", "stats.json"))
    render(file, view, 512, truth, ["--method", "reference"])
    rows = {name: {"ms": [], "psnr": 0, "splats": 0, "walks": 0} for name, _ in CONFIGS}
    for turn in range(rounds):
        for name, options in CONFIGS:
            render(file, view, 512, out, ["--method", "axis", *options], stats, 2)
            with open(stats, encoding="utf-8") as told:
                figures = json.load(told)
            row = rows[name]
            row["ms"].append(figures["frame_ms"]["median"])
            row["splats"] = int(re.search(r"(\d+) splats drawn", figures["plan"])[1])
            row["walks"] = figures["plan"].count("rays along")
            if turn == 0:
                row["psnr"] = error(out, truth)["covered"]["psnr"]
    return rows


def tables(files, view, rounds):
    for file in files:
        with tempfile.TemporaryDirectory() as folder:
            rows = one_table(file, view, rounds, folder)
        single = rows["single"]
        base = statistics.median(single["ms"])
        print(f"\n**{os.path.basename(file)}**, view {view}\n")
        print("| lists | walks | splats | of single | ms | of single | dB against exact order |")
        print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
        for name, _ in CONFIGS:
            row = rows[name]
            ms = statistics.median(row["ms"])
            print(f"| {name} | {row['walks']} | {row['splats']} | "
                  f"{row['splats'] / single['splats']:.2f} | {ms:.0f} | {ms / base:.2f} | "
                  f"{row['psnr']:.1f} |")


def popping(files, start, end, frames):
    ends = [[float(v) for v in text.split(",")] for text in (start, end)]
    ways = [("exact order", ["--method", "reference"])] + [
        (name, ["--method", "axis", *options]) for name, options in CONFIGS]
    for file in files:
        print(f"\n**{os.path.basename(file)}**, from {start} to {end} in {frames} frames\n")
        print("| lists | largest RMSE between frames | of exact order's |")
        print("| --- | ---: | ---: |")
        base = 0
        for name, options in ways:
            worst = largest_step(file, options, ends, frames)
            base = base or worst
            print(f"| {name} | {worst:.6f} | {worst / base:.2f} |", flush=True)


def largest_step(file, options, ends, frames):
    worst = 0
    with tempfile.TemporaryDirectory() as folder:
        paths = [os.path.join(folder, f"{i % 2}.exr") for i in range(2)]
        for i in range(frames):
            t = i / (frames - 1)
            view = ",".join(f"{a + t * (b - a):.6f}" for a, b in zip(*ends))
            render(file, view, 256, paths[i % 2], options)
            if i:
                worst = max(worst, error(paths[i % 2], paths[1 - i % 2])["all"]["rmse"])
    return worst if not math.isnan(worst) else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["tables", "popping"])
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--view", default="45,35.264")
    parser.add_argument("--to", default="45,35.264")
    parser.add_argument("--frames", type=int, default=21)
    parser.add_argument("--rounds", type=int, default=2)
    given = parser.parse_args()
    if given.what == "tables":
        tables(given.files, given.view, given.rounds)
    else:
        popping(given.files, given.view, given.to, given.frames)


main()
