#!/usr/bin/env python3
"""Scenes of glass that anyone can render: what docs/glass.md and docs/transparency.md show.

  tools/make_glass.py FOLDER                       writes the sky, a ball, and the scenes
  tools/make_glass.py FOLDER --model FILE.ply --ball X,Y,Z,R ...
                                                   and model.json: the model, transparent, with
                                                   opaque balls in it and around it; glass.json:
                                                   the model of glass, an index for each channel,
                                                   before the sky or --environment FILE

  stipple render FOLDER/sphere.json -o sphere.exr   a glass sphere before the sky
  stipple render FOLDER/beads.json -o beads.exr     opaque beads within a transparent knot
                                                   (Zhang & Pajarola 2006, Fig. 13)
  stipple render FOLDER/glass.json --layers multi --background environment -o glass.exr
                                                   or single: their Figs. 1 and 14

Deterministic, standard library only. The sky is a Radiance picture: a chequered ground, a sky that
pales towards the horizon, and a sun of 400.
"""
import json
import math
import os
import struct

import make_model
from command_line import Arguments, existing

WIDTH, HEIGHT = 512, 256
SUN = make_model.unit((0.45, 0.75, 0.5))
COLORS = [(0.85, 0.12, 0.08), (0.1, 0.5, 0.12), (0.1, 0.2, 0.8), (0.9, 0.65, 0.1)]


def ground(x, y, z):
    """Seen from one unit above a floor of squares; far ones fade into their mean."""
    a, b = x / -y, z / -y
    dark = (math.floor(a) + math.floor(b)) % 2 == 0
    near = math.exp(-0.08 * math.hypot(a, b))
    value = near * (0.08 if dark else 0.55) + (1 - near) * 0.3
    return value, 0.92 * value, 0.8 * value


def sky(x, y, z):
    if y < 0:
        return ground(x, y, z)
    pale = math.exp(-3 * y)
    color = [a + (b - a) * pale for a, b in zip((0.12, 0.3, 0.75), (0.85, 0.9, 0.95))]
    toward = make_model.dot((x, y, z), SUN)
    if toward > math.cos(math.radians(2.5)):
        return 400, 370, 320
    return tuple(c + 0.6 * max(0, toward) ** 64 for c in color)


def rgbe(color):
    mantissa, exponent = math.frexp(max(color))
    scale = mantissa * 256 / max(color)
    return bytes([*(min(255, int(c * scale)) for c in color), exponent + 128])


def write_sky(path):
    """docs/glass.md, "Directions": the centre is ahead, -z of up y; right of it is +x."""
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (HEIGHT, WIDTH))
        for j in range(HEIGHT):
            polar = math.pi * (j + 0.5) / HEIGHT
            for i in range(WIDTH):
                longitude = 2 * math.pi * ((i + 0.5) / WIDTH - 0.5)
                across = math.sin(polar)
                file.write(rgbe(sky(across * math.sin(longitude), math.cos(polar),
                                    -across * math.cos(longitude))))


def write_ball(path, count):
    """Points spread evenly over the unit sphere, along a spiral."""
    header = "ply\nformat binary_little_endian 1.0\ncomment made by tools/make_glass.py\n"
    header += f"element vertex {count}\n"
    header += "".join(f"property float {name}\n" for name in ["x", "y", "z", "nx", "ny", "nz"])
    with open(path, "wb") as file:
        file.write((header + "end_header\n").encode())
        for i in range(count):
            z, turn = 1 - (2 * i + 1) / count, i * math.pi * (3 - math.sqrt(5))
            r = math.sqrt(1 - z * z)
            p = (r * math.cos(turn), z, r * math.sin(turn))
            file.write(struct.pack("<6f", *p, *p))


def ball(center, radius, color):
    rows = [[radius if a == b else 0 for b in range(3)] + [center[a]] for a in range(3)]
    return {"file": "ball.ply", "transform": rows + [[0, 0, 0, 1]],
            "material": {"albedo": color, "specular": 0.4, "shininess": 64, "ior": 1}}


def camera(distance, fov):
    return {"world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -distance], [0, 0, 0, 1]],
            "fov_y_deg": fov}


def write_scene(folder, name, points, more):
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        json.dump({"up": "y", "points": points, **more}, file, indent=1)
        file.write("\n")


def sphere(folder):
    glass = {"opacity": 1e-6, "ior": [1.16, 1.18, 1.2], "absorption": [0.12, 0.03, 0.06]}
    write_scene(folder, "sphere.json", [{"file": "ball.ply", "material": glass}],
                {"environment": {"file": "sky.hdr"}, "camera": camera(6, 26)})


def beads(folder):
    shell = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "assets", "knot.ply")
    points = [{"file": os.path.relpath(shell, folder), "opacity": 0.3, "material": {"ior": 1}}]
    for i in range(12):
        at = make_model.knot(math.tau * i / 12)
        points.append(ball(at, 0.3, COLORS[i % 4]))
    write_scene(folder, "beads.json", points, {"camera": camera(14, 30)})


def within(folder, model, balls):
    points = [{"file": os.path.abspath(model), "opacity": 0.3, "material": {"ior": 1}}]
    for i, (x, y, z, r) in enumerate(balls):
        points.append(ball((x, y, z), r, COLORS[i % 4]))
    write_scene(folder, "model.json", points, {})


def of_glass(folder, model, environment):
    """Absorption a surface, as the models have few: two or four layers are told apart."""
    glass = {"opacity": 0.02, "ior": [1.1, 1.12, 1.14], "absorption": [0.3, 0.08, 0.15]}
    around = os.path.abspath(environment) if environment else "sky.hdr"
    write_scene(folder, "glass.json", [{"file": os.path.abspath(model), "material": glass}],
                {"environment": {"file": around}})


def place(text):
    """X,Y,Z,R"""
    numbers = [float(word) for word in text.split(",")]
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)) or numbers[3] <= 0:
        raise ValueError
    return numbers


def main():
    parser = Arguments(__doc__)
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--model", type=existing, metavar="FILE.ply")
    parser.add_argument("--ball", action="append", default=[], type=place, metavar="X,Y,Z,R")
    parser.add_argument("--environment", type=existing, metavar="FILE")
    options = parser.parse_args()
    if (options.ball or options.environment) and not options.model:
        parser.error("--ball and --environment are for a --model")
    os.makedirs(options.folder, exist_ok=True)
    write_sky(os.path.join(options.folder, "sky.hdr"))
    write_ball(os.path.join(options.folder, "ball.ply"), 20000)
    sphere(options.folder)
    beads(options.folder)
    if options.model:
        within(options.folder, options.model, options.ball)
        of_glass(options.folder, options.model, options.environment)


if __name__ == "__main__":
    main()
