#!/usr/bin/env python3
"""Normals near sharp edges, with clip lines and without, as a Markdown table (docs/phong.md).

  tools/bench_phong_edges.py [MESH.obj] [--fit SHARE,SHARE...] [--cloud POINTS.ply]

The mesh (without one: a generated solid with convex and reflex edges, and corners of three planes)
is sampled evenly, each sample with its face's normal; --cloud takes points of the same surface
instead. Splats are fitted with tolerances of so many diagonals of the bounding box; drawn as they
come, the same ones without their lines, and those of --fit-smooth; from three sides without perspective, without what faces
away (within epsilon behind an outline it would be averaged with what is seen). Over all pixels
whose surface lies within 1 % of the diagonal of an edge sharper than --sharp degrees: the angle
between the picture's normal and that of the mesh's face there, found by rasterizing the mesh with
code of its own. "wrong" are angles above 10 degrees; "uncovered" are pixels where no splat is.
"""
import json
import math
import os
import random
import re
import struct
import tempfile

from command_line import Arguments, STIPPLE, existing, positive, run, stipple

VIEWS = [(35, 25), (155, -20), (275, 50)]
NEAR = 0.01


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a)) or 1
    return (a[0] / length, a[1] / length, a[2] / length)


def read_obj(path):
    points, faces = [], []
    with open(path) as text:
        for words in map(str.split, text):
            if words[:1] == ["v"]:
                points.append(tuple(float(w) for w in words[1:4]))
            elif words[:1] == ["f"]:
                corners = [int(w.split("/")[0]) for w in words[1:]]
                corners = [c - 1 if c > 0 else len(points) + c for c in corners]
                faces += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return points, faces


def generated():
    """A stepped prism: right and slanted convex edges, two reflex ones, corners of three planes."""
    outline = [(0, 0), (3, 0), (3, 1), (2, 1), (1.6, 1.8), (0.8, 1.8), (0.8, 2.6), (0, 2.6)]
    n = len(outline)
    points = [(x, y, z) for z in (0, 1.4) for x, y in outline]
    faces = [f for i in range(n) for j in [(i + 1) % n]
             for f in ((i, j, n + j), (i, n + j, n + i))]
    ears = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 6), (0, 6, 7)]
    faces += [(n + a, n + b, n + c) for a, b, c in ears] + [(c, b, a) for a, b, c in ears]
    return points, faces


class Mesh:
    def __init__(self, points, faces, sharp):
        self.points, self.low = points, [min(p[k] for p in points) for k in range(3)]
        self.high = [max(p[k] for p in points) for k in range(3)]
        self.size = math.dist(self.low, self.high)
        corners = [[points[c] for c in f] for f in faces]
        spans = [cross(sub(b, a), sub(c, a)) for a, b, c in corners]
        self.kept = [i for i, s in enumerate(spans) if dot(s, s) > 0]
        self.faces = [corners[i] for i in self.kept]
        self.normals = [unit(spans[i]) for i in self.kept]
        self.areas = [math.sqrt(dot(spans[i], spans[i])) / 2 for i in self.kept]
        self.near = self.edge_grid([faces[i] for i in self.kept], math.cos(math.radians(sharp)))

    def cell(self, p):
        return tuple(int(math.floor(x / (NEAR * self.size))) for x in p)

    def edge_grid(self, faces, cosine):
        """Points on the sharp edges, a fifth of the distance asked for apart, by cell."""
        sides, grid = {}, {}
        for i, f in enumerate(faces):
            for k in range(3):
                sides.setdefault(tuple(sorted((f[k], f[k - 1]))), []).append(i)
        for (a, b), owners in sides.items():
            if len(owners) == 2 and dot(*(self.normals[i] for i in owners)) >= cosine:
                continue
            a, b = self.points[a], self.points[b]
            steps = 1 + int(math.dist(a, b) / (0.2 * NEAR * self.size))
            for s in range(steps + 1):
                p = tuple(x + (y - x) * s / steps for x, y in zip(a, b))
                grid.setdefault(self.cell(p), []).append(p)
        return grid

    def is_near(self, p):
        x, y, z = self.cell(p)
        return any(math.dist(p, q) < NEAR * self.size
                   for i in (x - 1, x, x + 1) for j in (y - 1, y, y + 1) for k in (z - 1, z, z + 1)
                   for q in self.near.get((i, j, k), ()))

    def sample(self, count, path):
        """Points spread evenly over the area: as PLY."""
        dice, total, done = random.Random(1), sum(self.areas), 0.0
        rows = []
        for (a, b, c), n, area in zip(self.faces, self.normals, self.areas):
            first, done = int(done), done + area * count / total
            for _ in range(first, int(done)):
                u, v = dice.random(), dice.random()
                u, v = (1 - u, 1 - v) if u + v > 1 else (u, v)
                rows.append(struct.pack("<3d3f", *(a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k])
                                                   for k in range(3)), *n))
        with open(path, "wb") as out:
            out.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(rows))
            out.write(b"".join(b"property double %c\n" % c for c in b"xyz"))
            out.write(b"".join(b"property float n%c\n" % c for c in b"xyz") + b"end_header\n")
            out.write(b"".join(rows))


class View:
    """Without perspective, the whole solid in a square of `pixels`."""
    def __init__(self, mesh, azimuth, elevation, pixels):
        a, e = math.radians(azimuth), math.radians(elevation)
        self.back = (math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a))
        self.right = unit(cross((0, 1, 0), self.back))
        self.up = cross(self.back, self.right)
        self.centre = [(x + y) / 2 for x, y in zip(mesh.low, mesh.high)]
        self.step, self.pixels, self.away = 1.05 * mesh.size / pixels, pixels, 2 * mesh.size

    def write(self, path):
        rows = [[*axis, -dot(axis, self.centre)] for axis in (self.right, self.up, self.back)]
        rows[2][3] -= self.away
        with open(path, "w") as out:
            json.dump({"world_to_camera": [*rows, [0, 0, 0, 1]],
                       "ortho_height": self.step * self.pixels}, out)

    def place(self, p):
        """In pixels, y down, and towards the eye."""
        d, half = sub(p, self.centre), self.pixels / 2
        return (dot(d, self.right) / self.step + half, half - dot(d, self.up) / self.step,
                dot(d, self.back))

    def world(self, column, row, z):
        x, y = (column + 0.5 - self.pixels / 2) * self.step, (self.pixels / 2 - row - 0.5) * self.step
        return tuple(c + x * r + y * u + z * b
                     for c, r, u, b in zip(self.centre, self.right, self.up, self.back))


def cover(corners, pixels):
    """(column, row, z) of the pixel centres in a triangle."""
    (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = corners
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0:
        return
    low, high = min(y0, y1, y2), max(y0, y1, y2)
    for row in range(max(0, math.ceil(low - 0.5)), min(pixels, math.floor(high - 0.5) + 1)):
        y = row + 0.5
        left, right = min(x0, x1, x2), max(x0, x1, x2)
        for column in range(max(0, math.ceil(left - 0.5)), min(pixels, math.floor(right - 0.5) + 1)):
            x = column + 0.5
            b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
            c = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
            if b >= 0 and c >= 0 and b + c <= 1:
                yield column, row, z0 + b * (z1 - z0) + c * (z2 - z0)


def truth(mesh, view):
    """(pixel, normal) of those near a sharp edge."""
    nearest = {}
    for face, normal in zip(mesh.faces, mesh.normals):
        if dot(normal, view.back) <= 0:
            continue
        for column, row, z in cover([view.place(p) for p in face], view.pixels):
            at = row * view.pixels + column
            if at not in nearest or z > nearest[at][0]:
                nearest[at] = (z, normal)
    return [(at, n) for at, (z, n) in nearest.items()
            if mesh.is_near(view.world(at % view.pixels, at // view.pixels, z))]


def normals(cloud, view, folder):
    """A triple a pixel, from the top."""
    camera, out = (os.path.join(folder, n) for n in ("camera.json", "out.exr"))
    view.write(camera)
    size = f"{view.pixels}x{view.pixels}"
    stipple("render", cloud, "-o", out, "-q", "--camera", camera, "--size", size, "--method", "exact",
            "--min-splat", "0", "--cull", "back")
    some = os.path.join(folder, "normals.exr")
    run("oiiotool", out, "--ch", "N.X,N.Y,N.Z", "-o", some)
    text = run("oiiotool", "--dumpdata", some).stdout
    found = [tuple(map(float, line.split(":")[1].split()))
             for line in text.splitlines() if line.lstrip().startswith("Pixel (")]
    assert len(found) == view.pixels ** 2
    return found


def without_lines(cloud, out):
    """The same splats, none of them clipped."""
    with open(cloud, "rb") as source:
        data = source.read()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    sizes = {"double": 8, "float": 4, "uint": 4, "uchar": 1}
    at, offset = 0, {}
    for words in map(str.split, data[:start].decode().splitlines()):
        if words[:1] == ["property"]:
            offset[words[2]] = at
            at += sizes[words[1]]
    body = bytearray(data)
    for name in ("clip_count", "clip_reflex"):
        first = start + offset[name]
        body[first::at] = bytes(len(range(first, len(data), at)))
    with open(out, "wb") as target:
        target.write(body)


def judge(pairs):
    """Mean angle in degrees, share of wrong ones, share of uncovered ones."""
    angles, uncovered = [], 0
    for seen, true in pairs:
        if dot(seen, seen) < 0.25:
            uncovered += 1
        else:
            angles.append(math.degrees(math.acos(max(-1, min(1, dot(unit(seen), true))))))
    wrong = sum(a > 10 for a in angles)
    return sum(angles) / len(angles), wrong / len(angles), uncovered / (uncovered + len(angles))


def measure(cloud, views, truths, folder):
    pairs = []
    for view, known in zip(views, truths):
        seen = normals(cloud, view, folder)
        pairs += [(seen[at], n) for at, n in known]
    return judge(pairs)


def fit(cloud, few, tolerance, more):
    """How many splats, and how many of them are clipped."""
    told = run(STIPPLE, "prepare", cloud, "-o", few, "--fit", repr(tolerance), *more).stderr
    return re.search(r"-> (\d+) splats.* (\d+) clipped", told).groups()


def main():
    parser = Arguments(__doc__)
    parser.add_argument("mesh", nargs="?", type=existing)
    parser.add_argument("--cloud", type=existing)
    parser.add_argument("--samples", type=positive, default=60000)
    parser.add_argument("--fit", type=lambda text: [float(n) for n in text.split(",")],
                        default=[0.0005, 0.001, 0.002])
    parser.add_argument("--sharp", type=float, default=30)
    parser.add_argument("--size", type=positive, default=600)
    options = parser.parse_args()
    mesh = Mesh(*(read_obj(options.mesh) if options.mesh else generated()), options.sharp)
    views = [View(mesh, *v, options.size) for v in VIEWS]
    truths = [truth(mesh, view) for view in views]
    print("| tolerance / diagonal | splats | clip lines | mean angle, degrees | wrong, % | uncovered, % |")
    print("|---" * 6 + "|")

    def row(*cells):
        print(f"| {cells[0]} | {cells[1]} | {cells[2]} | {cells[3]:.3f} | {100 * cells[4]:.2f} | "
              f"{100 * cells[5]:.3f} |", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        cloud, few = options.cloud, os.path.join(folder, "few.ply")
        if not cloud:
            cloud = os.path.join(folder, "cloud.ply")
            mesh.sample(options.samples, cloud)
        row("the points", "", "", *measure(cloud, views, truths, folder))
        for share in options.fit:
            row(share, *fit(cloud, few, share * mesh.size, []), *measure(few, views, truths, folder))
            bare = os.path.join(folder, "bare.ply")
            without_lines(few, bare)
            row(share, "the same", 0, *measure(bare, views, truths, folder))
            row(share, *fit(cloud, few, share * mesh.size, ["--fit-smooth"]),
                *measure(few, views, truths, folder))


if __name__ == "__main__":
    main()
