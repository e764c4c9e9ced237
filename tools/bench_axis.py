#!/usr/bin/env python3
"""Hofsetz and Max's tables on volumes, range images and points of your own, as Markdown.

  tools/bench_axis.py tables FILE... [--view AZ,EL] [--rounds N]   splats, times and errors
  tools/bench_axis.py speed FILE... [--view AZ,EL] [--rounds N]    times by compute and by raster
  tools/bench_axis.py volumes FILE... [--view AZ,EL] [--rounds N] [--pictures DIR]  a row a file
  tools/bench_axis.py popping FILE... [--view AZ,EL --to AZ,EL --frames N]
  tools/bench_axis.py cold FILE...                                 from the command to the EXR
  tools/bench_axis.py corners                                      weights from corners, not rays
  tools/bench_axis.py sheet OUT.png [FILE] [--view AZ,EL --to AZ,EL --frames N]

tables: splats drawn, the median of warm frames (interleaved over rounds), and the PSNR over covered
pixels against the exact order of the float64 reference; 512 x 512, as in the paper. speed: the same
frames, and what of them is the CPU's: the lists that a changed camera takes; ratios are of frames of
one round, their median and spread over the rounds (as many as --rounds, in at most five minutes for
all files). volumes: errors and times
of every merge, a row a file, 256 x 256, and a PNG of each. popping: the
largest RMSE between neighbouring frames of a path from --view to --to, 256 x 256, of every merge and
of the exact order itself. cold: wall clock of the whole command, the least of --rounds. corners: how far
HM's weights, interpolated from the corners of a splat's square, are from those of each pixel's ray, in
a view of all three axes. sheet: an orbit as a contact sheet, a row a merge, the exact order's last, and the
same rows as differences from it, times 4; needs oiiotool; without a FILE a volume is made for it.
docs/results/axis.md was made with it.
"""
import json
import math
import os
import re
import statistics
import tempfile
import time

from command_line import Arguments, positive, run, stipple

CONFIGS = [
    ("blend, h = 0", ["--axis-merge", "blend", "--axis-h", "0"]),
    ("blend, h = 0.85", ["--axis-merge", "blend"]),
    ("blend, h = 0.95", ["--axis-merge", "blend", "--axis-h", "0.95"]),
    ("clip", ["--axis-merge", "clip"]),
    ("single", ["--axis-merge", "single"]),
    ("sort", ["--axis-merge", "sort"]),
]

EXACT = ["--method", "axis", "--axis-merge", "reference"]


def render(file, view, size, out, more, stats=None, repeat=0):
    timing = ["--stats", stats, "--repeat", str(repeat)] if stats else []
    stipple("render", file, "--size", f"{size}x{size}", "--view", view, "-o", out, "-q",
        "--compression", "none", *more, *timing)


def error(a, b):
    """The figures over all pixels and over covered ones, of a against b."""
    return json.loads(stipple("compare", "--json", a, b))


def one_table(file, view, rounds, folder):
    truth, out, stats = (os.path.join(folder, n) for n in ("truth.exr", "out.exr", "stats.json"))
    render(file, view, 512, truth, EXACT)
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
    ways = [("exact order", EXACT)] + [
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


MERGES = ("blend", "clip", "single", "sort")


def one_volume(file, view, rounds, folder, pictures):
    """Splats, and of every merge the median of warm frames and its PSNR."""
    truth, out, stats = (os.path.join(folder, n) for n in ("truth.exr", "out.exr", "stats.json"))
    render(file, view, 256, truth, EXACT)
    rows = {merge: {"ms": []} for merge in MERGES}
    for turn in range(rounds):
        for merge, row in rows.items():
            more = ["--method", "axis", "--axis-merge", merge]
            if pictures and turn == 0:
                name = os.path.basename(file).split(".")[0]
                more += ["--preview", os.path.join(pictures, f"{name}_{merge}.png")]
            render(file, view, 256, out, more, stats, 2)
            with open(stats, encoding="utf-8") as told:
                figures = json.load(told)
            row["ms"].append(figures["frame_ms"]["median"])
            row["psnr"] = error(out, truth)["covered"]["psnr"]
    return figures["splats"], rows


def volumes(files, view, rounds, pictures):
    print(f"View {view}, 256 x 256: dB over covered pixels against the exact order, and ms.\n")
    print("| volume | kernels | " + " | ".join(MERGES) + " |")
    print("| --- | ---: |" + " ---: |" * len(MERGES))
    for file in files:
        with tempfile.TemporaryDirectory() as folder:
            splats, rows = one_volume(file, view, rounds, folder, pictures)
        print(f"| {os.path.basename(file)} | {splats} | " + " | ".join(
            f"{row['psnr']:.1f} dB, {statistics.median(row['ms']):.0f} ms" for row in rows.values())
              + " |", flush=True)


SPEED = [("compute", merge) for merge in MERGES] + [
    ("raster", merge) for merge in ("blend", "single")]


def one_frame(file, view, path, merge, folder):
    """The median of warm frames, and the CPU's part of it."""
    out, stats = os.path.join(folder, "out.exr"), os.path.join(folder, "stats.json")
    render(file, view, 512, out,
           ["--method", "axis", "--path", path, "--axis-merge", merge], stats,
           5 if path == "compute" else 2)
    with open(stats, encoding="utf-8") as told:
        figures = json.load(told)
    lists = [one["ms"] for one in figures["passes"] if one["name"].startswith("lists")]
    return figures["frame_ms"]["median"], lists[0] if lists else 0


def one_speed(file, view, rounds, folder, budget):
    """Of each way a pair a round. Rounds are whole, every second the other way round, and end after
    `budget` seconds; the first is thrown away where there are more than two, since it also warms up."""
    rows, end = {way: [] for way in SPEED}, time.monotonic() + budget
    for turn in range(rounds):
        began = time.monotonic()
        for way in SPEED[::-1] if turn % 2 else SPEED:
            rows[way].append(one_frame(file, view, *way, folder))
        now = time.monotonic()
        if now + (now - began) > end:
            break
    return {way: row[1:] if len(row) > 2 else row for way, row in rows.items()}


COMPARED = [("blend against single, compute", ("compute", "blend"), ("compute", "single")),
            ("blend against single, raster", ("raster", "blend"), ("raster", "single")),
            ("clip against sort, compute", ("compute", "clip"), ("compute", "sort")),
            ("blend against sort, compute", ("compute", "blend"), ("compute", "sort")),
            ("blend, compute against raster", ("compute", "blend"), ("raster", "blend")),
            ("single, compute against raster", ("compute", "single"), ("raster", "single"))]


def print_ratios(rows):
    """Both of a ratio are of one round, so that what slows a round slows both."""
    print("\n| what | median of the rounds' ratios | least | greatest |")
    print("| --- | ---: | ---: | ---: |")
    for what, one, other in COMPARED:
        ratios = [a[0] / b[0] for a, b in zip(rows[one], rows[other])]
        print(f"| {what} | {statistics.median(ratios):.2f} | {min(ratios):.2f} | {max(ratios):.2f} |")


def speed(files, view, rounds):
    for file in files:
        with tempfile.TemporaryDirectory() as folder:
            rows = one_speed(file, view, rounds, folder, 280 / len(files))
        print(f"\n**{os.path.basename(file)}**, view {view}, {len(rows[SPEED[0]])} rounds\n")
        print("| path | lists | frame, ms | least | greatest | of it lists on the CPU |")
        print("| --- | --- | ---: | ---: | ---: | ---: |")
        for path, merge in SPEED:
            frames = [frame for frame, _ in rows[path, merge]]
            lists = statistics.median(ms for _, ms in rows[path, merge])
            print(f"| {path} | {merge} | {statistics.median(frames):.0f} | {min(frames):.0f} | "
                  f"{max(frames):.0f} | {lists:.0f} |")
        print_ratios(rows)


def cold(files, rounds):
    print("| volume | from the command to the EXR, s |")
    print("| --- | ---: |")
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            least = math.inf
            for _ in range(rounds):
                start = time.monotonic()
                stipple("render", file, "--size", "512x512", "-o", os.path.join(folder, "o.exr"), "-q")
                least = min(least, time.monotonic() - start)
            print(f"| {os.path.basename(file)} | {least:.2f} |", flush=True)


def weights_at(x, y, focal, h):
    """HM 5.2 on the ray of a pixel, relative to the centre of a view down the diagonal."""
    root2, root3, root6 = math.sqrt(2), math.sqrt(3), math.sqrt(6)
    v = [1 / root3 + y / focal / root6 * -1 + x / focal / root2,
         1 / root3 + y / focal / root6 * 2,
         1 / root3 + y / focal / root6 * -1 - x / focal / root2]
    most = max(abs(c) for c in v)
    return [max((c / most - h) / (1 - h), 0) for c in v]


def shares(w):
    total = sum(c * c for c in w)
    return [c * c / total if total > 0 else 0 for c in w]


def corner_error(side, h, focal):
    """The greatest and mean error of a list's share over squares of that side, 512 x 512."""
    worst = total = count = 0
    for left in range(-256, 256 - side, 37):
        for top in range(-256, 256 - side, 37):
            corners = [weights_at(left + side * i, top + side * j, focal, h)
                       for j in (0, 1) for i in (0, 1)]
            for j in range(0, side, max(1, side // 5)):
                for i in range(0, side, max(1, side // 5)):
                    s, t = (i + 0.5) / side, (j + 0.5) / side
                    mixed = [(1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d)
                             for a, b, c, d in zip(*corners)]
                    exact = shares(weights_at(left + i + 0.5, top + j + 0.5, focal, h))
                    far = max(abs(a - b) for a, b in zip(shares(mixed), exact))
                    worst, total, count = max(worst, far), total + far, count + 1
    return worst, total / count


def corners():
    focal = 256 / math.tan(math.radians(22.5))
    print("| side of the square, pixels | h | greatest error of a share w^2 / sum w^2 | mean |")
    print("| ---: | ---: | ---: | ---: |")
    for side in (5, 20, 100):
        for h in (0.85, 0.95):
            worst, mean = corner_error(side, h, focal)
            print(f"| {side} | {h} | {worst:.4f} | {mean:.6f} |")


def shell_volume(folder):
    """Two crossed rings in a thin shell: what lies in front of what changes with the view."""
    side, values = 48, bytearray()
    for i in range(side ** 3):
        x, y, z = (2 * (c + 0.5) / side - 1 for c in (i % side, i // side % side, i // side // side))
        rings = min(math.hypot(math.hypot(x, y) - 0.55, z), math.hypot(math.hypot(y, z) - 0.55, x))
        shell = abs(math.sqrt(x * x + y * y + z * z) - 0.9)
        values.append(230 if rings < 0.13 else 90 if shell < 0.06 else 0)
    raw = os.path.join(folder, "rings.raw")
    with open(raw, "wb") as out:
        out.write(values)
    with open(raw + ".json", "w", encoding="utf-8") as out:
        json.dump({"dims": [side] * 3, "dtype": "uint8"}, out)
    look = os.path.join(folder, "look.json")
    with open(look, "w", encoding="utf-8") as out:
        json.dump({"points": [{"value": 40, "opacity": 0, "color": "#4080ff"},
                              {"value": 90, "opacity": 0.05, "color": "#4080ff"},
                              {"value": 160, "opacity": 0.1, "color": "#ffb040"},
                              {"value": 230, "opacity": 0.9, "color": "#ffb040"}]}, out)
    return raw, ["--transfer-function", look]


def sheet(out, file, start, end, frames, size):
    ends = [[float(v) for v in text.split(",")] for text in (start, end)]
    ways = [CONFIGS[i] for i in (4, 3, 1, 5)] + [("exact order", EXACT)]
    with tempfile.TemporaryDirectory() as folder:
        look = []
        if not file:
            file, look = shell_volume(folder)
        cells = [[os.path.join(folder, f"{row}-{i}.exr") for i in range(frames)]
                 for row in range(len(ways))]
        for row, (_, options) in enumerate(ways):
            for i in range(frames):
                t = i / max(frames - 1, 1)
                view = ",".join(f"{a + t * (b - a):.6f}" for a, b in zip(*ends))
                render(file, view, size, cells[row][i], [*options, *look])
        off = [os.path.join(folder, f"off-{row}-{i}.exr")
               for row in range(len(ways) - 1) for i in range(frames)]
        for n, path in enumerate(off):
            row, i = divmod(n, frames)
            run("oiiotool", cells[row][i], "--ch", "R,G,B", cells[-1][i], "--ch", "R,G,B", "--absdiff",
                    "--mulc", "4", "-o", path)
        shown = [path for row in cells for path in row]
        run("oiiotool", *(word for path in shown + off for word in (path, "--ch", "R,G,B")),
                "--mosaic:pad=2", f"{frames}x{2 * len(ways) - 1}", "--colorconvert", "linear", "sRGB", "-d",
                "uint8", "-o", out)
    print(f"{out}: from the top " + ", ".join(name for name, _ in ways) +
          "; then the first four's differences from the last, times 4")


def main():
    parser = Arguments(__doc__)
    parser.add_argument("what", choices=["tables", "speed", "volumes", "popping", "cold", "corners",
                                         "sheet"])
    parser.add_argument("files", nargs="*", metavar="FILE")
    parser.add_argument("--view", default="45,35.264")
    parser.add_argument("--to", default="45,35.264")
    parser.add_argument("--frames", type=positive, default=21)
    parser.add_argument("--rounds", type=positive)
    parser.add_argument("--pictures", metavar="DIR")
    given = parser.parse_args()
    files = given.files[1:] if given.what == "sheet" else given.files
    if given.what not in ("corners", "sheet") and not files:
        parser.error(f"{given.what} takes FILE...")
    if given.what == "sheet" and not 1 <= len(given.files) <= 2:
        parser.error("sheet takes OUT.png [FILE]")
    if given.what == "corners" and files:
        parser.error("corners takes no file")
    for file in files:
        if not os.path.exists(file):
            parser.error(f"{file}: no such file")
    given.rounds = given.rounds or (20 if given.what == "speed" else 2)
    if given.what == "tables":
        tables(given.files, given.view, given.rounds)
    elif given.what == "speed":
        speed(given.files, given.view, given.rounds)
    elif given.what == "volumes":
        volumes(given.files, given.view, given.rounds, given.pictures)
    elif given.what == "cold":
        cold(given.files, given.rounds)
    elif given.what == "corners":
        corners()
    elif given.what == "sheet":
        out, *file = given.files
        sheet(out, file[0] if file else None, given.view, given.to, given.frames, 96)
    else:
        popping(given.files, given.view, given.to, given.frames)


if __name__ == "__main__":
    main()
