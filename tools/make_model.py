#!/usr/bin/env python3
"""Makes assets/knot.ply: a scaled trefoil knot round a pearl, as coloured points with normals.

Deterministic, standard library only. The points carry no radius: finding it is the renderer's work.

  tools/make_model.py [OUT.ply]
"""
import math
import os
import struct

from command_line import Arguments

RING, MINOR, TUBE = 2.2, 1.0, 0.52  # of the knot, and the tube's radius without relief
SPACING = 0.0405                    # between neighbours, in scene units
SCALES_ROUND, SCALES_ALONG = 10, 78  # even and matched, so that the pattern closes
RELIEF = 0.075
PEARL = 0.56
TAU = 2 * math.pi


def add(a, b, s=1.0):
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def knot(t):
    """The (2, 3) torus knot."""
    w = RING + MINOR * math.cos(3 * t)
    return (w * math.cos(2 * t), w * math.sin(2 * t), MINOR * math.sin(3 * t))


def frame(t):
    """Two directions across the curve that close after one turn: away from the torus' core."""
    step = 1e-4
    tangent = unit(add(knot(t + step), knot(t - step), -1))
    core = (RING * math.cos(2 * t), RING * math.sin(2 * t), 0.0)
    out = add(knot(t), core, -1)
    out = unit(add(out, tangent, -dot(out, tangent)))
    return out, cross(tangent, out)


def scale_height(t, v):
    """In [0, 1]: a dome on each rhombus of a diagonal lattice, with a groove between."""
    a, b = SCALES_ROUND * v / TAU, SCALES_ALONG * t / TAU
    p, q = (a + b) / 1.0, (b - a) / 1.0
    p, q = 2 * (p - math.floor(p)) - 1, 2 * (q - math.floor(q)) - 1
    dome = (1 - p * p) * (1 - q * q)
    lift = 0.75 + 0.25 * (p + q) / 2  # each scale rises towards its tip
    return lift * dome ** 0.6 if dome > 0 else 0.0


def surface(t, v):
    out, side = frame(t)
    radius = TUBE + RELIEF * scale_height(t, v)
    across = add((0.0, 0.0, 0.0), out, radius * math.cos(v))
    return add(knot(t), add(across, side, radius * math.sin(v)))


def normal(t, v):
    dt, dv = 4e-4, 4e-3
    along = add(surface(t + dt, v), surface(t - dt, v), -1)
    around = add(surface(t, v + dv), surface(t, v - dv), -1)
    n = unit(cross(around, along))
    out, side = frame(t)
    outward = add(add((0.0, 0.0, 0.0), out, math.cos(v)), side, math.sin(v))
    return n if dot(n, outward) > 0 else (-n[0], -n[1], -n[2])


STOPS = [(0.03, 0.28, 0.42), (0.05, 0.45, 0.42), (0.93, 0.74, 0.32), (0.88, 0.33, 0.20),
         (0.52, 0.13, 0.35), (0.16, 0.21, 0.54)]


def palette(x):
    """A closed run through STOPS, sRGB."""
    x = (x - math.floor(x)) * len(STOPS)
    i, f = int(x) % len(STOPS), x - math.floor(x)
    f = f * f * (3 - 2 * f)
    low, high = STOPS[i], STOPS[(i + 1) % len(STOPS)]
    return tuple(a + f * (b - a) for a, b in zip(low, high))


def knot_color(t, v):
    height = scale_height(t, v)
    r, g, b = palette(t / TAU + 0.04 * math.sin(v))
    shade = 0.45 + 0.55 * min(1.0, height * 1.6)
    gold = max(0.0, 1 - height / 0.22) * 0.6  # a thin gilt line in the grooves
    r, g, b = r * shade, g * shade, b * shade
    return (r + gold * (0.80 - r), g + gold * (0.62 - g), b + gold * (0.30 - b))


def pearl_color(n):
    sheen = 0.5 + 0.5 * n[2]
    return (0.93 - 0.05 * sheen, 0.87 + 0.04 * sheen, 0.85 + 0.08 * sheen)


def knot_points():
    """Rings at equal arc length, each turned by half a step against the last."""
    samples = 20000
    length = [0.0]
    for i in range(samples):
        step = add(knot(TAU * (i + 1) / samples), knot(TAU * i / samples), -1)
        length.append(length[-1] + math.sqrt(dot(step, step)))
    rings = round(length[-1] / (SPACING * math.sqrt(3) / 2) / 2) * 2
    around = round(TAU * (TUBE + RELIEF / 2) / SPACING)
    i = 0
    for ring in range(rings):
        goal = length[-1] * ring / rings
        while length[i + 1] < goal:
            i += 1
        t = TAU * (i + (goal - length[i]) / (length[i + 1] - length[i])) / samples
        for k in range(around):
            v = TAU * (k + 0.5 * (ring % 2)) / around
            yield surface(t, v), normal(t, v), knot_color(t, v)


def pearl_points():
    """A Fibonacci sphere."""
    count = round(4 * math.pi * PEARL ** 2 / (SPACING * SPACING * math.sqrt(3) / 2))
    for i in range(count):
        z = 1 - (2 * i + 1) / count
        r, angle = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
        n = (r * math.cos(angle), r * math.sin(angle), z)
        yield (PEARL * n[0], PEARL * n[1], PEARL * n[2]), n, pearl_color(n)


HEADER = """ply
format binary_little_endian 1.0
comment a scaled trefoil knot round a pearl; made by tools/make_model.py of stipple
element vertex %d
property float x
property float y
property float z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
end_header
"""


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = Arguments(__doc__)
    parser.add_argument("out", nargs="?", metavar="OUT.ply",
                        default=os.path.join(here, "..", "assets", "knot.ply"))
    path = parser.parse_args().out
    points = [*knot_points(), *pearl_points()]
    with open(path, "wb") as out:
        out.write((HEADER % len(points)).encode("ascii"))
        for position, n, color in points:
            rgb = [max(0, min(255, round(255 * c))) for c in color]
            out.write(struct.pack("<6f3B", *position, *n, *rgb))
    print("%s: %d points" % (os.path.normpath(path), len(points)))


if __name__ == "__main__":
    main()
