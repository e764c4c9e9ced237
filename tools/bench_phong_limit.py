#!/usr/bin/env python3
"""How well fields of normals over a point's nearest neighbours can be, as Markdown tables.

  tools/bench_phong_limit.py FILE...      what `tools/bench_phong.py limit` prints, which also makes shapes
"""
import math
import os
import random
import struct
import tempfile

from command_line import Arguments, existing, stipple

COUNTS = [1000, 3000, 10000, 30000, 100000]  # of splats
CENTERS = 400
FURTHEST = 1024  # points of a splat
SIZES = {"double": "d", "float": "f", "uint": "I", "uchar": "B"}


def read_splats(file):
    """Position and normal of each prepared splat."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "all.ply")
        stipple("prepare", file, "-o", path)
        with open(path, "rb") as source:
            data = source.read()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    words = [line.split() for line in data[:start].decode().splitlines()]
    names = [w[2] for w in words if w[:1] == ["property"]]
    layout = struct.Struct("<" + "".join(SIZES[w[1]] for w in words if w[:1] == ["property"]))
    pick = [names.index(n) for n in ("x", "y", "z", "nx", "ny", "nz")]
    count = next(int(w[2]) for w in words if w[:2] == ["element", "vertex"])
    rows = layout.iter_unpack(data[start:start + count * layout.size])
    return [tuple(row[i] for i in pick) for row in rows]


class Grid:
    """Cells of about 16 points of a surface."""
    def __init__(self, points):
        spans = [max(p[k] for p in points) - min(p[k] for p in points) for k in range(3)]
        self.size = max(spans) * math.sqrt(16 / len(points))
        self.cells, self.points = {}, points
        for i, p in enumerate(points):
            self.cells.setdefault(self.cell(p), []).append(i)

    def cell(self, p):
        return tuple(int(p[k] // self.size) for k in range(3))

    def nearest(self, p, most):
        """The nearest points on p's side of the surface, nearest first; fewer than asked where it
        ends."""
        x, y, z = self.cell(p)
        for reach in range(1, 20):
            near = []
            for i in range(x - reach, x + reach + 1):
                for j in range(y - reach, y + reach + 1):
                    for k in range(z - reach, z + reach + 1):
                        near += self.cells.get((i, j, k), ())
            near = [(math.dist(p[:3], q[:3]), q) for q in (self.points[i] for i in near)
                    if p[3] * q[3] + p[4] * q[4] + p[5] * q[5] > 0.3]
            inside = sorted(pair for pair in near if pair[0] <= reach * self.size)
            if len(inside) >= most or len(inside) == len(self.points):
                break
        return [q for _, q in inside[:most]]


def tangents(n):
    axis = (1, 0, 0) if abs(n[0]) < 0.6 else (0, 1, 0)
    along = sum(a * b for a, b in zip(axis, n))
    u = [a - along * b for a, b in zip(axis, n)]
    length = math.sqrt(sum(a * a for a in u))
    u = [a / length for a in u]
    return u, (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0])


def residuals(p, near):
    """Mean squared angles that are left by a constant normal and by a linear field (with the mixed
    terms that Eq. 2 leaves out): the least squares of tangents, weighted as angles are."""
    u, v = tangents(p[3:])
    sums = [0.0] * 13
    for q in near:
        d, n = [a - b for a, b in zip(q[:3], p[:3])], q[3:]
        s, t = sum(map(lambda a, b: a * b, d, u)), sum(map(lambda a, b: a * b, d, v))
        z = sum(map(lambda a, b: a * b, n, p[3:]))
        x, y = sum(map(lambda a, b: a * b, n, u)) / z, sum(map(lambda a, b: a * b, n, v)) / z
        terms = (1, s, t, s * s, s * t, t * t, x, x * s, x * t, y, y * s, y * t, x * x + y * y)
        sums = [a + z ** 4 * b for a, b in zip(sums, terms)]
    one, s, t, ss, st, tt, x, xs, xt, y, ys, yt, rest = sums
    rest -= (x * x + y * y) / one
    constant = rest
    ss, st, tt = ss - s * s / one, st - s * t / one, tt - t * t / one
    det = ss * tt - st * st
    for a, b in ((xs - x * s / one, xt - x * t / one), (ys - y * s / one, yt - y * t / one)):
        if det > 1e-6 * (ss + tt) ** 2:
            rest -= (a * (a * tt - b * st) + b * (b * ss - a * st)) / det
    return constant / one, max(rest, 0) / one


def measure(points, sizes):
    """Sizes of neighbourhoods -> (constant, linear), root mean square angles in degrees."""
    grid, dice = Grid(points), random.Random(1)
    sums, used = {n: [0.0, 0.0] for n in sizes}, 0
    for p in dice.sample(points, min(CENTERS, len(points))):
        near = grid.nearest(p, max(sizes))
        if len(near) < max(sizes):
            continue
        used += 1
        for n in sizes:
            for k, value in enumerate(residuals(p, near[:n])):
                sums[n][k] += value
    return {n: [math.degrees(math.sqrt(value / max(used, 1))) for value in sums[n]] for n in sizes}


def splats_of_same_angle(angles, total, wanted):
    """By interpolation in logarithms."""
    rows = sorted((n, a[0]) for n, a in angles.items())
    for (few, a), (many, b) in zip(rows, rows[1:]):
        if a <= wanted <= b:
            return total / (few * (many / few) ** (math.log(wanted / a) / math.log(b / a)))
    return None


def print_limits(name, file, counts):
    points = read_splats(file)
    asked = [n for n in (round(len(points) / c) for c in counts) if 5 <= n <= FURTHEST]
    sizes = sorted({*asked, 4, 5, 6, 8, 11, 16, 22, 32, 44, 64, 88, 128, 176})
    angles = measure(points, sizes)
    print(f"\n{name}, {len(points)} points\n")
    print("| splats | points of each | constant, degrees | linear, degrees | constant splats of that angle |")
    print("|---|---|---|---|---|")
    for n in sorted(asked, reverse=True):
        splats, linear = len(points) / n, angles[n][1]
        equal = splats_of_same_angle(angles, len(points), linear)
        cell = f"{equal:.0f} ({equal / splats:.1f} x)" if equal else f"above {len(points) / 4:.0f}"
        print(f"| {splats:.0f} | {n} | {angles[n][0]:.2f} | {linear:.2f} | {cell} |", flush=True)


def main():
    parser = Arguments(__doc__)
    parser.add_argument("files", nargs="+", type=existing, metavar="FILE")
    for file in parser.parse_args().files:
        print_limits(os.path.basename(file), file, COUNTS)


if __name__ == "__main__":
    main()
