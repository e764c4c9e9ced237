#!/usr/bin/env python3
"""What stands behind the figures of docs/transparency.md, as Markdown tables.

  tools/bench_transparency.py cover              duplicates that K = 4 groups of equal discs take for
                                                 98 % each, beside the least that any choice can do
  tools/bench_transparency.py order [N]          a frame of N discs (1,000,000): the walk of the trees
  tools/bench_transparency.py layers FILE.ply... nearest against fast, by how many layers a pixel
                                                 has. Where fast's errors in the nearest layer and
                                                 behind it cancel, it is better by luck: `by luck` is
                                                 the share of pixels where they could, halved, since
                                                 one sign is as likely as the other
  tools/bench_transparency.py seam [N]           a slope of N discs (60,000), one layer over many
                                                 slabs: by how much each way is too opaque, and ms
"""
import array
import json
import math
import os
import random
import struct
import tempfile

import bench
from command_line import Arguments, stipple

TARGET, GROUPS = 0.98, 4


def sphere(path, count, radius, scattered):
    """Equal discs over the unit sphere, along a spiral or at random."""
    dice = random.Random(1)
    with open(path, "wb") as file:
        file.write(bench.discs_header(count))
        for i in range(count):
            z = dice.uniform(-1, 1) if scattered else 1 - (2 * i + 1) / count
            turn = dice.uniform(0, math.tau) if scattered else i * math.pi * (3 - math.sqrt(5))
            r = math.sqrt(1 - z * z)
            p = (r * math.cos(turn), r * math.sin(turn), z)
            file.write(struct.pack("<7f", *p, *p, radius))


def covered(density):
    """Of a hexagon of area 1, by the disc of that area about its middle."""
    radius, inner = math.sqrt(density / math.pi), math.sqrt(1 / (2 * math.sqrt(3)))
    if radius <= inner:
        return density
    angle = min(math.acos(inner / radius), math.pi / 6)
    return 6 * (inner ** 2 * math.tan(angle) + radius ** 2 * (math.pi / 6 - angle))


def least_density(share):
    """L. Fejes Toth's moment theorem: however n equal discs lie, they cover at most what they would
    as the middles of a honeycomb. So a share of the plane takes discs of this area, a unit of it."""
    low, high = 0.0, 2.0
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if covered(middle) < share else (low, middle)
    return high


def statistics_of(model, *more):
    with tempfile.TemporaryDirectory() as folder:
        stats = os.path.join(folder, "s.json")
        stipple("render", model, "-q", "--opacity", "0.5", "--stats", stats, *more)
        with open(stats, encoding="utf-8") as file:
            return json.load(file)


def cover(folder, count=20000):
    density = least_density(TARGET)
    print(f"{100 * TARGET:.0f} % takes discs of {density:.4f} of the area at least\n")
    print("| discs over each other | spread | least duplicates | taken | largest factor of radii | "
          "covered |\n|---:|---|---:|---:|---:|---:|")
    model = os.path.join(folder, "sphere.ply")
    for over in [2, 2.5, 3, 3.5, 4, 5]:
        for scattered in [False, True]:
            sphere(model, count, math.sqrt(4 * over / count), scattered)
            made = statistics_of(model, "--size", "8x8", "--transparency", "fast", "--groups",
                                 str(GROUPS))["grouping"]
            least = max(0, GROUPS * density / over / max(made["factor"]) ** 2 - 1)
            print(f"| {over} | {'scattered' if scattered else 'even'} | {100 * least:.0f} % | "
                  f"{100 * made['duplicates']:.0f} % | {max(made['factor']):.3f} | "
                  f"{100 * min(made['coverage']):.1f} % |", flush=True)


def order(folder, count):
    model = os.path.join(folder, "sphere.ply")
    sphere(model, count, math.sqrt(16 / count), True)
    print("| way | order, ms | a frame, ms | slowest, ms |\n|---|---:|---:|---:|")
    for way in ["fast", "nearest"]:
        stats = statistics_of(model, "--size", "1024x1024", "--transparency", way, "--repeat", "5")
        walk = next(p["ms"] for p in stats["passes"] if p["name"].startswith("order"))
        frame = stats["frame_ms"]
        print(f"| {way}, {count} discs | {walk:.1f} | {frame['median']:.1f} | {frame['max']:.1f} |")


def planes(path):
    """Of a scanline EXR without compression: its float channels."""
    with open(path, "rb") as file:
        data = file.read()
    at, names, window = 8, [], None
    while data[at]:
        name_end = data.index(0, at)
        kind_end = data.index(0, name_end + 1)
        size = struct.unpack_from("<i", data, kind_end + 1)[0]
        name, at = data[at:name_end], kind_end + 5
        if name == b"channels":
            names = [c for c in data[at:at + size].split(b"\0") if c and c.isascii() and
                     all(32 < b < 127 for b in c)]
        elif name == b"dataWindow":
            window = struct.unpack_from("<4i", data, at)
        at += size
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    first = at + 1 + 8 * height
    line = 8 + 4 * width * len(names)
    out = {}
    for k, name in enumerate(names):
        plane = array.array("f")
        for y in range(height):
            start = first + y * line + 8 + 4 * width * k
            plane.frombytes(data[start:start + 4 * width])
        out[name.decode()] = plane
    return out


def errors(image, truth, pixels):
    return [sum((image[c][i] - truth[c][i]) ** 2 for c in "RGB") / 3 for i in pixels]


def worse_and_luck(fast, nearest, difference):
    """Shares of the pixels where nearest is off by over 1/255 more than fast is; and of half of
    those where a difference of the right sign would make it so."""
    step, worse, coins = 1 / 255, 0, 0
    for f, n, d in zip(fast, nearest, difference):
        f, n, d = math.sqrt(f), math.sqrt(n), math.sqrt(d)
        worse += n > f + step
        coins += step < d < 2 * n - step
    return worse / len(fast), coins / 2 / len(fast)


def decibels(squares):
    mean = sum(squares) / len(squares)
    return -10 * math.log10(mean) if mean > 0 else math.inf


def layers(folder, models):
    print("| model | layers | pixels | fast, dB | nearest, dB | nearest worse by over 1/255 | by luck "
          "|\n|---|---|---:|---:|---:|---:|---:|")
    view, out = (os.path.join(folder, n) for n in ["view.json", "o.exr"])
    for model in models:
        bench.camera(model, view)
        for opacity in ["0.3", "0.6"]:
            pictures = {}
            for way in ["reference", "fast", "nearest"]:
                count = ["--aov", "layers"] if way == "reference" else []
                bench.layers(model, view, ["--opacity", opacity, "--transparency", way, *count,
                                           "--compression", "none", "-o", out], folder, "0")
                pictures[way] = planes(out)
            truth = pictures["reference"]
            for low, high in [(1, 1), (2, 2), (3, 3), (4, 5), (6, 999), (2, 999)]:
                pixels = [i for i, n in enumerate(truth["layers"]) if low <= n <= high]
                if not pixels:
                    continue
                a, b = (errors(pictures[way], truth, pixels) for way in ["fast", "nearest"])
                worse, luck = worse_and_luck(a, b, errors(pictures["fast"], pictures["nearest"],
                                                          pixels))
                name = str(low) if low == high else f"{low} to {high}" if high < 999 else f"{low} up"
                print(f"| {os.path.basename(model)}, {opacity} | {name} | {len(pixels)} | "
                      f"{decibels(a):.1f} | {decibels(b):.1f} | {100 * worse:.2f} % | "
                      f"{100 * luck:.2f} % |", flush=True)


SLOPE = {"width": 2.3, "epsilon": 0.1, "spread": 0.02, "alpha": 0.5}


def slope(path, count):
    """Discs of one tilted plane, depth 4 + x, that lie up to a fifth of an epsilon behind it."""
    dice = random.Random(7)
    radius = SLOPE["width"] * math.sqrt(4.5 * math.sqrt(2) / (math.pi * count))
    tilt = math.sqrt(0.5)
    with open(path, "wb") as file:
        file.write(bench.discs_header(count))
        for _ in range(count):
            x, y = (SLOPE["width"] * (dice.random() - 0.5) for _ in range(2))
            z = -4 - x - SLOPE["spread"] * dice.random()
            file.write(struct.pack("<7f", x, y, z, tilt, 0, tilt, radius))


def excess(alpha, size):
    """Of opacity over the layer's own: in the mean, along the worst line of equal depth (a column of
    the picture), and at most; without the rim, and without the few pixels that no disc covers."""
    rim = size // 16
    inner = range(rim, size - rim)
    lines = [[alpha[y * size + x] - SLOPE["alpha"] for y in inner if alpha[y * size + x] > 0]
             for x in inner]
    means = [sum(line) / len(line) for line in lines]
    return sum(means) / len(means), max(means), max(max(map(abs, line)) for line in lines)


def seam(folder, count, size=1024):
    """The camera looks along -z at a square of 2 units: columns are lines of equal depth."""
    model, view, out = (os.path.join(folder, n) for n in ["slope.ply", "view.json", "o.exr"])
    slope(model, count)
    with open(view, "w", encoding="ascii") as file:
        json.dump({"world_to_camera": [[int(a == b) for b in range(4)] for a in range(4)],
                   "ortho_height": 2, "width": size, "height": size, "near": 1, "far": None}, file)
    print("| way | too opaque, mean | along a line | in a pixel, at most | ms a frame |\n"
          "|---|---:|---:|---:|---:|")
    for way in [["fast"], ["nearest"], ["exact"], ["peel", "--peel-layers", "1"]]:
        ms = bench.layers(model, view, ["--opacity", str(SLOPE["alpha"]), "--epsilon",
                                        str(SLOPE["epsilon"]), "--transparency", *way,
                                        "--compression", "none", "-o", out], folder)
        mean, line, most = excess(planes(out)["A"], size)
        print(f"| {' '.join(way)} | {mean:.5f} | {line:.5f} | {most:.5f} | {ms:.1f} |", flush=True)


def main():
    parser = Arguments(__doc__)
    parser.add_argument("what", choices=["cover", "order", "layers", "seam"])
    parser.add_argument("arguments", nargs="*")
    options = parser.parse_args()
    if options.what == "layers":
        if not options.arguments:
            parser.error("layers takes FILE.ply...")
        for path in options.arguments:
            if not os.path.exists(path):
                parser.error(f"{path}: no such file")
    elif options.arguments and (options.what == "cover" or len(options.arguments) > 1
                                or not options.arguments[0].isdecimal()):
        parser.error(f"{options.what} takes {'nothing more' if options.what == 'cover' else 'one number'}")
    with tempfile.TemporaryDirectory() as folder:
        if options.what == "cover":
            cover(folder)
        elif options.what == "order":
            order(folder, int((options.arguments or ["1000000"])[0]))
        elif options.what == "seam":
            seam(folder, int((options.arguments or ["60000"])[0]))
        else:
            layers(folder, options.arguments)


if __name__ == "__main__":
    main()
