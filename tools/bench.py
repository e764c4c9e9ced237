#!/usr/bin/env python3
"""Accuracy and speed of the methods on models of your own, as Markdown tables.

  tools/bench.py accuracy FILE.ply...            errors against the float64 reference
  tools/bench.py speed FILE.ply... [--peers DIR] times, interleaved over rounds; DIR may hold other
                                                 programs, `em FILE OUT 1p1 SIZE FRAMES` and
                                                 `sp FILE OUT SIZE FRAMES`, to run between ours
  tools/bench.py transparency FILE.ply...        error and time of transparent pictures, opacity
                                                 0.3 and 0.6, both faces; interleaved over rounds
                                                 with the same splats, opaque; then the ratios,
                                                 round by round: their median and middle half. In
                                                 parts: --part errors or times, --opacity A. --part
                                                 ratios times what is closest to its bar only: seven
                                                 rounds in five minutes

The view is the one that point renderers are compared with here: the centre of the bounding box from
direction (0.4, 0.3, 1), y up, 30 degrees, the largest |ndc| of a centre 0.95; 1024 x 1024, back
faces culled, parabola kernel, no screen-space floor, epsilon the median radius. Input is binary
little-endian PLY. docs/results/ was made with it.
"""
import json
import math
import os
import re
import statistics
import struct
import sys
import tempfile

from command_line import Arguments, existing, positive, run, stipple

SIZE = 1024
VIEW = ["--size", f"{SIZE}x{SIZE}", "--cull", "back", "--min-splat", "0", "-q"]
LETTERS = {"float": "f", "float32": "f", "double": "d", "float64": "d", "uchar": "B", "uint8": "B",
           "int": "i", "int32": "i", "uint": "I", "ushort": "H", "short": "h"}
ACCURACY = [
    ["exact"], ["exact", "--payload", "id"], ["two-pass", "--path", "compute"],
    ["two-pass", "--path", "raster"],
    *[["deferred", "--overlap", c, "--voronoi", v] for c in ["1.0", "0.85", "0.8", "0.6", "0.4"]
      for v in ["off", "slab", "exact"]],
    ["deferred", "--overlap", "0.4", "--path", "raster"],
]
SPEED = [
    ["exact"], ["exact", "--payload", "id"], ["deferred", "--overlap", "0.4"], ["deferred"],
    ["deferred", "--overlap", "0.4", "--payload", "id"], ["two-pass", "--path", "compute"],
    ["two-pass", "--path", "raster"], ["deferred", "--overlap", "0.4", "--path", "raster"],
]

TRANSPARENT = [["exact"], ["exact", "--payload", "id"], ["fast"], ["nearest"],
               *[[way, "--groups", k] for way in ["fast", "nearest"] for k in ["2", "4"]],
               *[["peel", "--peel-layers", k] for k in ["1", "2", "4", "8", "16"]],
               ["peel", "--path", "raster"]]
OPAQUE = [["deferred", "--overlap", "0.4"], ["deferred"], ["two-pass", "--path", "compute"],
          ["two-pass", "--path", "raster"]]
# What is divided by what, of one opacity unless opaque, and the most that is aimed at.
RATIOS = [
    ("fast", "peel --path raster", 0.13), ("nearest", "peel --path raster", 0.20),
    ("fast", "two-pass --path raster, opaque", 1.6), ("exact", "peel --peel-layers 8", 0.33),
    ("exact", "deferred, opaque", 1.5), ("exact", "deferred --overlap 0.4, opaque", 1.5),
    ("a peeled layer", "two-pass --path compute, opaque", 1.1),
]
CLOSE = [RATIOS[0], RATIOS[1], RATIOS[2], RATIOS[5]]


def positions(path):
    """The points of a binary little-endian PLY."""
    with open(path, "rb") as file:
        count, inside, names, letters = 0, False, [], "<"
        while True:
            words = file.readline().decode("ascii", "replace").split()
            if words[0] == "element":
                inside = words[1] == "vertex"
                count = int(words[2]) if inside else count
            elif words[0] == "property" and inside:
                letters += LETTERS[words[1]]
                names.append(words[2])
            elif words[0] == "end_header":
                break
        record = struct.Struct(letters)
        x, y, z = (names.index(name) for name in "xyz")
        return [(r[x], r[y], r[z]) for r in record.iter_unpack(file.read(count * record.size))]


def discs_header(count):
    """Of a binary PLY whose rows are seven floats: a place, a normal, a radius."""
    names = ["x", "y", "z", "nx", "ny", "nz", "radius"]
    return (f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n" +
            "".join(f"property float {name}\n" for name in names) + "end_header\n").encode()


def unit(v):
    length = math.sqrt(sum(c * c for c in v))
    return [c / length for c in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def camera(path, out):
    points = positions(path)
    middle = [(min(c) + max(c)) / 2 for c in zip(*points)]
    back = unit([0.4, 0.3, 1])
    right = unit(cross([0, 1, 0], back))
    axes = (right, cross(back, right), back)
    edge, distance = 0.95 * math.tan(math.radians(15)), 0
    for point in points:
        d = [point[k] - middle[k] for k in range(3)]
        x, y, z = (sum(d[k] * axis[k] for k in range(3)) for axis in axes)
        distance = max(distance, abs(x) / edge + z, abs(y) / edge + z)
    eye = [middle[k] + distance * back[k] for k in range(3)]
    rows = [axis + [-sum(axis[k] * eye[k] for k in range(3))] for axis in axes]
    with open(out, "w", encoding="ascii") as file:
        json.dump({"world_to_camera": rows + [[0, 0, 0, 1]], "fov_y_deg": 30, "width": SIZE,
                   "height": SIZE, "near": distance * 1e-3, "far": None}, file)


def render(model, view, method, *more):
    stipple("render", model, "--camera", view, *VIEW, "--method", *method, *more)


def accuracy(models, folder):
    print("| model | method | PSNR, dB | mean absolute | over 1/255 | coverage differs | normal, "
          "degrees |\n|---|---|---:|---:|---:|---:|---:|")
    for model in models:
        view, truth, out = (os.path.join(folder, n) for n in ["view.json", "t.exr", "o.exr"])
        camera(model, view)
        render(model, view, ["reference"], "-o", truth)
        for method in ACCURACY:
            render(model, view, method, "-o", out)
            error = json.loads(stipple("compare", "--json", out, truth))
            covered = error["covered"]
            print(f"| {os.path.basename(model)} | {' '.join(method)} | "
                  f"{covered['psnr'] or math.inf:.1f} | {covered['mean_absolute']:.2e} | "
                  f"{100 * covered['over_1_255']:.3f} % | {error['coverage_differs']} | "
                  f"{error['normal_mean']:.4f} |", flush=True)


def peer(program, model, folder):
    mode = ["1p1"] if os.path.basename(program) == "em" else []
    text = run(program, model, os.path.join(folder, "p.pfm"), *mode, str(SIZE), "7").stdout
    return float(re.search(r"median ([0-9.]+) ms", text).group(1))


def frame(model, view, method, folder):
    stats = os.path.join(folder, "s.json")
    render(model, view, method, "--repeat", "7", "--stats", stats)
    with open(stats, encoding="utf-8") as file:
        return json.load(file)["frame_ms"]["median"]


def speed(models, folder, peers, rounds):
    print("| model | what | ms a frame, median | range over rounds | of two-pass raster |\n"
          "|---|---|---:|---:|---:|")
    for model in models:
        view, times = os.path.join(folder, "view.json"), {}
        camera(model, view)
        for _ in range(rounds):
            for name in ["em", "sp"] if peers else []:
                times.setdefault(name, []).append(peer(os.path.join(peers, name), model, folder))
            for method in SPEED:
                times.setdefault(" ".join(method), []).append(frame(model, view, method, folder))
        base = times["two-pass --path raster"]
        for what, ms in times.items():
            ratio = statistics.median(a / b for a, b in zip(ms, base))
            print(f"| {os.path.basename(model)} | {what} | {statistics.median(ms):.1f} | "
                  f"{min(ms):.1f} - {max(ms):.1f} | {ratio:.2f} |", flush=True)


def layers(model, view, more, folder, repeat="7"):
    stats = os.path.join(folder, "s.json")
    stipple("render", model, "--camera", view, *VIEW, "--cull", "none", *more, "--repeat", repeat,
            "--stats", stats)
    with open(stats, encoding="utf-8") as file:
        return json.load(file)["frame_ms"]["median"]


def ratios(model, opacity, times, which):
    """Of the same round; their median, and the range of their middle half. A peeled layer: an
    eighth of what layers 9 to 16 take."""
    def of(name):
        return times[name if name.endswith("opaque") else f"{name}, opacity {opacity}"]
    if which is RATIOS:
        times[f"a peeled layer, opacity {opacity}"] = [
            (b - a) / 8 for a, b in zip(of("peel --peel-layers 8"), of("peel --peel-layers 16"))]
    for what, base, most in which:
        values = sorted(a / b for a, b in zip(of(what), of(base)))
        cut = len(values) // 4
        print(f"| {os.path.basename(model)}, opacity {opacity} | {what} / {base} | "
              f"{statistics.median(values):.3f} | {values[cut]:.3f} - {values[-1 - cut]:.3f} | "
              f"{most:.2f} |", flush=True)


def faded(opacity):
    """Name and options of every way to draw a model of that opacity."""
    return {f"{' '.join(way)}, opacity {opacity}": ["--opacity", opacity, "--transparency", *way]
            for way in TRANSPARENT}


def transparent_errors(model, view, opacity, folder):
    truth, out = (os.path.join(folder, n) for n in ["t.exr", "o.exr"])
    layers(model, view, ["--opacity", opacity, "--transparency", "reference", "-o", truth], folder,
           "0")
    for name, way in faded(opacity).items():
        layers(model, view, [*way, "-o", out], folder, "0")
        covered = json.loads(stipple("compare", "--json", out, truth))["covered"]
        print(f"| {os.path.basename(model)} | {name} | {covered['psnr'] or math.inf:.1f} | "
              f"{covered['maximum']:.3f} |", flush=True)


def timed_ways(opacities, which):
    ways = {name: way for opacity in opacities for name, way in faded(opacity).items()}
    ways.update((f"{' '.join(way)}, opaque", ["--method", *way]) for way in OPAQUE)
    if which is RATIOS:
        return ways
    names = {name for what, base, _ in which for name in [what, base]}
    return {name: way for name, way in ways.items() if {name, name.split(", opacity")[0]} & names}


def transparent_times(model, view, opacities, folder, rounds, which):
    ways, times = timed_ways(opacities, which), {}
    repeat = "3" if which is RATIOS else "1"
    for _ in range(rounds):
        for name, way in ways.items():
            times.setdefault(name, []).append(layers(model, view, way, folder, repeat))
    for name, ms in times.items():
        print(f"| {os.path.basename(model)} | {name} | {statistics.median(ms):.1f} | "
              f"{min(ms):.1f} - {max(ms):.1f} |", flush=True)
    return times


def transparency(models, folder, options):
    view, opacities, measured = os.path.join(folder, "view.json"), options.opacity or ["0.3", "0.6"], {}
    which = CLOSE if options.part == "ratios" else RATIOS
    if options.part not in ["times", "ratios"]:
        print("| model | what | PSNR, dB | worst |\n|---|---|---:|---:|", flush=True)
        for model in models:
            camera(model, view)
            for opacity in opacities:
                transparent_errors(model, view, opacity, folder)
    if options.part == "errors":
        return
    print("\n| model | what | ms a frame, median | range over rounds |\n|---|---|---:|---:|",
          flush=True)
    for model in models:
        camera(model, view)
        measured[model] = transparent_times(model, view, opacities, folder, options.rounds,
                                            which)
    print("\n| model | ratio of times | median | middle half | at most |\n|---|---|---:|---:|---:|")
    for model, times in measured.items():
        for opacity in opacities:
            ratios(model, opacity, times, which)


def main():
    parser = Arguments(__doc__)
    parser.add_argument("what", choices=["accuracy", "speed", "transparency"])
    parser.add_argument("models", nargs="+", type=existing, metavar="FILE.ply")
    parser.add_argument("--peers", type=existing, metavar="DIR")
    parser.add_argument("--rounds", type=positive, help="default: 5; of ratios: 7")
    parser.add_argument("--part", choices=["errors", "times", "ratios"],
                        help="of transparency; default: errors and times")
    parser.add_argument("--opacity", action="append", metavar="A",
                        help="of transparency; default: 0.3 and 0.6")
    options = parser.parse_args()
    options.rounds = options.rounds or (7 if options.part == "ratios" else 5)
    with tempfile.TemporaryDirectory() as folder:
        if options.what == "accuracy":
            accuracy(options.models, folder)
        elif options.what == "transparency":
            transparency(options.models, folder, options)
        else:
            speed(options.models, folder, options.peers, options.rounds)


if __name__ == "__main__":
    sys.exit(main())
