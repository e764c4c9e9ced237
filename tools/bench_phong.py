#!/usr/bin/env python3
"""Botsch, Spernat and Kobbelt's comparison on models of your own, as Markdown.

  tools/bench_phong.py curve FILE... [--counts N,N...] [--view AZ,EL] [--method M]
  tools/bench_phong.py fit FILE... [--counts N,N...] [--rounds N]

curve: the error (mean absolute linear RGB over covered pixels, 1024 x 1024) of fitted splats against
the picture of the whole cloud, by the number of splats: Phong (linear fields), averaged (constant
normals, averaged, shaded once: the default of discs), and, where the command has --shade splat,
blended (constant normals, shaded, then blended, as the paper blends). Then how many constant splats
reach the error of each number of Phong splats, by interpolation in logarithms. fit: points a second,
the median of the rounds. All fits are `stipple prepare --fit-count`, of one generator.
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


def run(*arguments):
    return subprocess.run([STIPPLE, *arguments], check=True, capture_output=True, text=True)


def has_option(command, option):
    return re.search(re.escape(option) + r"[ =]", run(command, "--help").stdout) is not None


def fit(file, count, out, flat=False):
    """The splats that came out, and the milliseconds that it took."""
    told = run("prepare", file, "-o", out, "--fit-count", str(count), *(["--fit-flat"] * flat))
    found = re.search(r"(\d+) points -> (\d+) splats.* (\d+) ms", told.stderr)
    return int(found[2]), int(found[1]), float(found[3])


def render(file, arguments, out, more=()):
    run("render", file, "-o", out, "-q", "--size", "1024x1024", "--view", arguments.view,
        "--method", arguments.method, "--min-splat", "0", *more)


def error(a, b):
    return json.loads(run("compare", "--json", a, b).stdout)["covered"]["mean_absolute"]


def ways():
    """Name, constant fields?, options of the render."""
    known = [("Phong", False, []), ("averaged", True, [])]
    if has_option("render", "--shade"):
        known.append(("blended", True, ["--shade", "splat"]))
    return known


def measure(file, arguments, folder):
    """Rows of way -> (splats, error), a count."""
    truth, cloud, out = (os.path.join(folder, n) for n in ("truth.exr", "few.ply", "out.exr"))
    render(file, arguments, truth)
    rows = []
    for count in arguments.counts:
        row = {}
        for name, flat, more in ways():
            splats, _, _ = fit(file, count, cloud, flat)
            render(cloud, arguments, out, more)
            row[name] = (splats, error(out, truth))
        rows.append(row)
    return rows


def reaching(rows, name, wanted):
    """The splats with which `name` comes down to the error, None: never within the counts."""
    for few, many in zip(rows, rows[1:]):
        (n, a), (m, b) = few[name], many[name]
        if b <= wanted <= a and a > b:
            share = math.log(a / wanted) / math.log(a / b)
            return n * (m / n) ** share
    return None


def print_curve(file, rows):
    names = list(rows[0])
    print(f"\n{os.path.basename(file)}\n\n| splats | {' | '.join(names)} |")
    print("|---" * (len(names) + 1) + "|")
    for row in rows:
        print(f"| {row['Phong'][0]} | {' | '.join(f'{row[n][1]:.5f}' for n in names)} |")
    print(f"\n| Phong splats | {' | '.join(names[1:])}, for the same error |")
    print("|---" * len(names) + "|")
    for row in rows:
        splats, wanted = row["Phong"]
        cells = []
        for name in names[1:]:
            count = reaching(rows, name, wanted)
            cells.append(f"{count:.0f} ({count / splats:.1f} x)" if count else "outside the counts")
        print(f"| {splats} | {' | '.join(cells)} |")


def curve(arguments):
    with tempfile.TemporaryDirectory() as folder:
        for file in arguments.file:
            print_curve(file, measure(file, arguments, folder))


def fits(arguments):
    print("| model | splats | points a second |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for file in arguments.file:
            for count in arguments.counts:
                told = run("prepare", file, "-o", os.path.join(folder, "few.ply"), "--fit-count",
                           str(count)).stderr
                tolerance = re.search(r"tolerance (\S+),", told)[1]
                rates = []
                for _ in range(arguments.rounds):
                    told = run("prepare", file, "-o", os.path.join(folder, "few.ply"), "--fit",
                               tolerance).stderr
                    found = re.search(r"(\d+) points -> (\d+) splats.* (\d+) ms", told)
                    rates.append(1e3 * int(found[1]) / float(found[3]))
                print(f"| {os.path.basename(file)} | {found[2]} | {statistics.median(rates):.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["curve", "fit"])
    parser.add_argument("file", nargs="+")
    parser.add_argument("--counts", type=lambda text: [int(n) for n in text.split(",")],
                        default=[1000, 3000, 10000, 30000, 100000])
    parser.add_argument("--view", default="35,15")
    parser.add_argument("--method", default="two-pass")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    {"curve": curve, "fit": fits}[arguments.what](arguments)


if __name__ == "__main__":
    main()
