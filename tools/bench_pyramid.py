#!/usr/bin/env python3
"""The pyramid's tables, as Markdown, in the view of tools/bench.py.

  tools/bench_pyramid.py time DENSE.ply       paper's Table 1: clouds of 25,000 to 5,000,000 points
                                              out of DENSE, at 512 x 512 and 1024 x 1024; and the
                                              same clouds by `deferred`, which it is to beat; then
                                              what pull and push take at both sizes
  tools/bench_pyramid.py crossing DENSE.ply   544,000 points of DENSE with discs of several widths:
                                              where `deferred` is as fast
  tools/bench_pyramid.py holes FILE...        pixels that the reference covers and it leaves empty,
                                              and its errors; any file of points
  tools/bench_pyramid.py normals              a sphere 900 pixels across, 1 point in 1 to 256 pixels,
                                              against the true normals
  tools/bench_pyramid.py samples FILE.ply     error, of outlines too, and time with 1, 4 and 16
                                              samples a pixel
  tools/bench_pyramid.py stream N FOLDER      a sphere of N points (28 bytes each, written there)
                                              from its file: time and memory

Clouds are binary little-endian PLY whose vertices are x y z nx ny nz radius, floats. DENSE has its
points drawn evenly over a surface; a cloud out of it has every n-th, their discs that much wider.
"""
import json
import math
import os
import random
import statistics
import struct
import sys
import tempfile

import bench
from command_line import Arguments, stipple

SIZES = [512, 1024]
COUNTS = [25000, 173000, 544000, 3600000, 5000000]
ROW = struct.Struct("<7f")


def subset(path, count, out, factor=1):
    """Every n-th point, as few as asked for, radii times the factor. Returns how many there are."""
    with open(path, "rb") as file:
        total = 0
        for line in iter(file.readline, b"end_header\n"):
            if line.startswith(b"element vertex"):
                total = int(line.split()[2])
        data = file.read(total * ROW.size)
    count = min(count, total)
    wider = math.sqrt(total / count) * factor
    with open(out, "wb") as file:
        file.write(bench.discs_header(count))
        if count == total and factor == 1:
            file.write(data)
            return count
        for i in range(count):
            row = ROW.unpack_from(data, i * total // count * ROW.size)
            file.write(ROW.pack(*row[:6], row[6] * wider))
    return count


def run(model, view, size, method, *more):
    """The statistics of warm frames."""
    with tempfile.TemporaryDirectory() as folder:
        stats = os.path.join(folder, "s.json")
        stipple("render", model, "--camera", view, "--size", f"{size}x{size}", "--cull",
                      "back", "--min-splat", "0", "-q", "--method", *method, "--stats", stats,
                      *more)
        with open(stats, encoding="utf-8") as file:
            return json.load(file)


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


PARTS = ["projection", "gather", "push", "rim"]


def part_of(name):
    if name.startswith(("project", "clear keys")):
        return "projection"
    if name == "gather" or name.startswith("rim"):
        return name.split()[0]
    return "push" if name.startswith(("pull", "push", "blocks")) else "rest"


def spent(stats):
    """Milliseconds of each part."""
    parts = dict.fromkeys([*PARTS, "rest"], 0)
    for one in stats["passes"]:
        parts[part_of(one["name"])] += one["ms"]
    return parts


def deferred(model, view, size):
    """Milliseconds by compute and by the rasteriser."""
    return [run(model, view, size, ["deferred", "--overlap", "0.4", "--path", path], "--repeat",
                "7")["frame_ms"]["median"] for path in ["compute", "raster"]]


def time_table(dense, folder):
    view, files, shares = os.path.join(folder, "view.json"), [], {}
    for count in COUNTS:
        out = os.path.join(folder, f"{count}.ply")
        files.append((subset(dense, count, out), out))
    bench.camera(files[0][1], view)
    row("points", "picture", "projection", "gather", "pull, push, shade", "rim", "frame",
        "points/s", "`deferred`", "its ratio")
    print("|---:|---:|" + "---:|" * 8)
    for count, model in files:
        for size in SIZES:
            ours = run(model, view, size, ["pyramid"], "--repeat", "7")
            theirs = min(deferred(model, view, size))
            parts, frame = spent(ours), ours["frame_ms"]["median"]
            shares.setdefault(count, []).append(parts["push"] + parts["rim"])
            row(count, f"{size} x {size}", *[f"{parts[k]:.1f}" for k in PARTS], f"{frame:.1f}",
                f"{count / frame / 1e3:.1f} M", f"{theirs:.1f}", f"{theirs / frame:.2f}")
    print()
    row("points", *[f"pull, push, shade and rim, {s} x {s}" for s in SIZES], "ratio")
    print("|---:|" + "---:|" * (len(SIZES) + 1))
    for count, share in shares.items():
        row(count, *[f"{ms:.1f}" for ms in share], f"{share[-1] / share[0]:.2f}")


def pixels_of_radius(model, view, size):
    """What a disc of the median radius takes at the depth of the first points, on average."""
    with open(view, encoding="utf-8") as file:
        camera = json.load(file)
    with open(model, "rb") as file:
        for line in iter(file.readline, b"end_header\n"):
            pass
        rows = list(ROW.iter_unpack(file.read(1000 * ROW.size)))
    toward = camera["world_to_camera"][2]
    depth = statistics.mean(-sum(t * c for t, c in zip(toward, [*r[:3], 1])) for r in rows)
    focal = size / 2 / math.tan(math.radians(camera["fov_y_deg"]) / 2)
    return statistics.median(r[6] for r in rows) * focal / depth


def crossing(dense, folder):
    model, view = (os.path.join(folder, n) for n in ["c.ply", "view.json"])
    rows = []
    row("radius, pixels", "pyramid", "`deferred`, compute", "raster", "best over pyramid")
    print("|---:|" + "---:|" * 4)
    for factor in [0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 2.8]:
        subset(dense, 544000, model, factor)
        if not rows:
            bench.camera(model, view)
        radius = pixels_of_radius(model, view, bench.SIZE)
        ours = run(model, view, bench.SIZE, ["pyramid"], "--repeat", "7")["frame_ms"]["median"]
        theirs = deferred(model, view, bench.SIZE)
        rows.append((radius, min(theirs) / ours))
        row(f"{radius:.2f}", f"{ours:.1f}", *[f"{ms:.1f}" for ms in theirs], f"{rows[-1][1]:.2f}")
    for (r, a), (s, b) in zip(rows, rows[1:]):
        if a <= 1 < b:
            print(f"\nThey cross at a radius of {r + (s - r) * (1 - a) / (b - a):.2f} pixels.")


def planes(path, names):
    """Float channels of a scanline OpenEXR without compression, as lists of rows."""
    with open(path, "rb") as file:
        data = file.read()
    at, channels, window = 8, [], None
    while data[at]:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        at = data.index(b"\0", at) + 1
        size, at = struct.unpack_from("<i", data, at)[0], at + 4
        if name == "channels":
            inside = at
            while data[inside]:
                end = data.index(b"\0", inside)
                channels.append((data[inside:end].decode(),
                                 struct.unpack_from("<i", data, end + 1)[0]))
                inside = end + 17
        elif name == "dataWindow":
            window = struct.unpack_from("<4i", data, at)
        at += size
    at += 1
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    found = {name: [] for name in names}
    for offset in struct.unpack_from(f"<{height}Q", data, at):
        place = offset + 8
        for name, kind in channels:
            if name in found:
                found[name].append(struct.unpack_from(f"<{width}f", data, place))
            place += width * (2 if kind == 1 else 4)
    return found


def holes(models, folder):
    row("model", "covered", "holes", "share", "covered by one only", "PSNR, dB",
        "normal, mean degrees")
    print("|---|" + "---:|" * 6)
    view, truth, out = (os.path.join(folder, n) for n in ["view.json", "t.exr", "o.exr"])
    for path in models:
        model = os.path.join(folder, "prepared.ply")
        stipple("prepare", path, "-o", model, "-q")
        bench.camera(model, view)
        for method, picture in ["reference", truth], ["pyramid", out]:
            bench.render(model, view, [method], "-o", picture, "--compression", "none")
        error = json.loads(stipple("compare", "--json", out, truth))
        ours, theirs = (planes(picture, ["Z"])["Z"] for picture in [out, truth])
        covered = missing = 0
        for a, b in zip(ours, theirs):
            covered += sum(z < math.inf for z in b)
            missing += sum(z < math.inf <= y for y, z in zip(a, b))
        row(os.path.basename(path), covered, missing, f"{missing / covered:.1e}",
            error["coverage_differs"], f"{error['covered']['psnr'] or math.inf:.1f}",
            f"{error['normal_mean']:.2f}")


def sphere(count, out):
    """Even points on the unit sphere, discs of four times a point's share of the area."""
    radius = 2 * math.sqrt(4 / count)
    with open(out, "wb") as file:
        file.write(bench.discs_header(count))
        for i in range(count):
            z, turn = 1 - (2 * i + 1) / count, i * 2.399963229728653
            ring = math.sqrt(1 - z * z)
            n = (ring * math.cos(turn), ring * math.sin(turn), z)
            file.write(ROW.pack(*n, *n, radius))


ACROSS, DISTANCE, EDGE = 900, 4, 1024


def write_view(out):
    """The sphere ACROSS pixels wide, at DISTANCE."""
    focal = ACROSS / 2 * math.sqrt(DISTANCE * DISTANCE - 1)
    with open(out, "w", encoding="ascii") as file:
        json.dump({"world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -DISTANCE],
                                       [0, 0, 0, 1]],
                   "intrinsics": {"fx": focal, "fy": focal, "cx": EDGE / 2, "cy": EDGE / 2},
                   "width": EDGE, "height": EDGE, "near": 0.1, "far": None}, file)
    return focal


def sphere_error(path, focal):
    """Mean and largest degrees where the sphere faces the eye by more than a fifth; empty pixels."""
    planes_of = planes(path, ["Z", "N.X", "N.Y", "N.Z"])
    total, largest, seen, empty = 0, 0, 0, 0
    for y in range(EDGE):
        rows = [planes_of[name][y] for name in ["Z", "N.X", "N.Y", "N.Z"]]
        for x, (z, *n) in enumerate(zip(*rows)):
            ray = ((x + 0.5 - EDGE / 2) / focal, -(y + 0.5 - EDGE / 2) / focal, -1)
            a = sum(c * c for c in ray)
            under = DISTANCE * DISTANCE - a * (DISTANCE * DISTANCE - 1)
            if under <= 0:
                continue
            t = (DISTANCE - math.sqrt(under)) / a
            true = (ray[0] * t, ray[1] * t, DISTANCE - t)
            if -sum(c * d for c, d in zip(true, ray)) < 0.2 * math.sqrt(a):
                continue
            seen += 1
            if not z < math.inf:
                empty += 1
                continue
            cosine = max(-1, min(1, sum(c * d for c, d in zip(true, n))))
            across = math.dist(true, n)
            angle = math.degrees(2 * math.asin(min(1, across / 2)) if cosine > 0 else
                                 math.acos(cosine))
            total += angle
            largest = max(largest, angle)
    return total / (seen - empty), largest, empty


def normals(folder):
    row("one point in", "points", "mean, degrees", "largest", "holes")
    print("|---:|" + "---:|" * 4)
    model, view, out = (os.path.join(folder, n) for n in ["s.ply", "v.json", "o.exr"])
    focal = write_view(view)
    for pixels in [1, 4, 16, 64, 256]:
        count = int(2 * math.pi * (ACROSS / 2) ** 2 / pixels)  # half of them face the eye
        sphere(count, model)
        bench.render(model, view, ["pyramid"], "-o", out, "--compression", "none", "--size",
                     f"{EDGE}x{EDGE}")
        mean, largest, empty = sphere_error(out, focal)
        row(f"{pixels} pixel{'s' if pixels > 1 else ''}", count, f"{mean:.3f}", f"{largest:.2f}",
            empty)


def outline_error(ours, theirs):
    """Mean absolute error of coverage, over pixels that either covers in part."""
    errors = [abs(a - b) for x, y in zip(ours, theirs) for a, b in zip(x, y) if 0 < b < 1 or a != b]
    return statistics.mean(errors) if errors else 0, len(errors)


def samples(model, folder):
    """Against the reference with 64 samples."""
    view, truth, out = (os.path.join(folder, n) for n in ["view.json", "t.exr", "o.exr"])
    bench.camera(model, view)
    plain = ["--compression", "none", "-o"]
    bench.render(model, view, ["reference"], "--samples", "64", *plain, truth)
    wanted = planes(truth, ["A"])["A"]
    row("samples", "ms a frame", "PSNR, dB", "mean absolute", "pixels of outlines",
        "their coverage, mean absolute")
    print("|---:|" + "---:|" * 5)
    for count in [1, 4, 16]:
        stats = run(model, view, bench.SIZE, ["pyramid"], "--samples", str(count), "--repeat", "3",
                    *plain, out)
        error = json.loads(stipple("compare", "--json", out, truth))["covered"]
        coverage, pixels = outline_error(planes(out, ["A"])["A"], wanted)
        row(count, f"{stats['frame_ms']['median']:.1f}", f"{error['psnr']:.1f}",
            f"{error['mean_absolute']:.2e}", pixels, f"{coverage:.3f}")


def write_cloud(count, path):
    """A bumpy sphere, in no order."""
    random.seed(7)
    radius, block = 2 * math.sqrt(4 / count), []
    with open(path, "wb") as file:
        file.write(bench.discs_header(count))
        for i in range(count):
            z, turn = random.uniform(-1, 1), random.uniform(0, 2 * math.pi)
            ring = math.sqrt(1 - z * z)
            n = (ring * math.cos(turn), ring * math.sin(turn), z)
            bump = 1 + 0.05 * math.sin(9 * n[0]) * math.sin(7 * n[1])
            block.append(ROW.pack(*(bump * c for c in n), *n, radius))
            if len(block) == 65536 or i + 1 == count:
                file.write(b"".join(block))
                block.clear()


def stream(count, folder):
    model, view = os.path.join(folder, f"sphere_{count}.ply"), os.path.join(folder, "view.json")
    if not os.path.exists(model):
        write_cloud(count, model)
    write_view(view)
    stats = run(model, view, EDGE, ["pyramid"], "--stream", "on", "--preview",
                os.path.join(folder, "stream.png"))
    cold, sizes = stats["cold_ms"], stats["bytes"]
    row("points", "file, MB", "prepare, s", "frame, s", "device, MB", "process at most, MB")
    print("|---:|" + "---:|" * 5)
    row(count, f"{os.path.getsize(model) / 1e6:.0f}", f"{cold['prepare'] / 1e3:.1f}",
        f"{cold['first_frame'] / 1e3:.1f}", f"{sizes['peak'] / 1e6:.0f}",
        f"{stats['peak_rss'] / 1e6:.0f}")


def main():
    parser = Arguments(__doc__)
    parser.add_argument("table", choices=["time", "crossing", "holes", "normals", "samples", "stream"])
    parser.add_argument("arguments", nargs="*")
    given = parser.parse_args()
    wanted = {"holes": "FILE...", "normals": "", "stream": "N FOLDER"}.get(given.table, "FILE.ply")
    few, many = len(wanted.split()), math.inf if given.table == "holes" else len(wanted.split())
    if not few <= len(given.arguments) <= many:
        parser.error(f"{given.table} takes {wanted or 'nothing more'}")
    if given.table == "stream" and not given.arguments[0].isdecimal():
        parser.error(f"stream takes a number of points, not {given.arguments[0]}")
    for path in given.arguments[given.table == "stream":]:
        if not os.path.exists(path):
            parser.error(f"{path}: no such file")
    with tempfile.TemporaryDirectory() as folder:
        if given.table == "time":
            time_table(given.arguments[0], folder)
        elif given.table == "crossing":
            crossing(given.arguments[0], folder)
        elif given.table == "holes":
            holes(given.arguments, folder)
        elif given.table == "normals":
            normals(folder)
        elif given.table == "samples":
            samples(given.arguments[0], folder)
        else:
            stream(int(given.arguments[0]), given.arguments[1])


if __name__ == "__main__":
    sys.exit(main())
