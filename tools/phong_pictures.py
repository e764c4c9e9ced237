#!/usr/bin/env python3
"""The pictures of docs/phong.md, of generated shapes; they want oiiotool.

  tools/phong_pictures.py fields OUT.png [--splats N] [--size PIXELS]
  tools/phong_pictures.py edges OUT.png [--size PIXELS]

fields: a smooth knot of 400,000 points, and the same N splats three times: flat (the nearest one's
normal), blended (constant normals, shaded, then blended), and with linear normal fields. edges: the
solid of tools/bench_phong_edges.py, its splats at 1 : 1, the corner that the frame is about at
20 : 1, the same without their clip lines, and the points.
"""
import os
import tempfile

import bench_phong
import bench_phong_edges
import command_line

CORNER = (2, 1, 1.4)  # where a reflex edge ends: of the solid
ZOOM = 20


def run(*arguments):
    bench_phong.run(*arguments)


def side_by_side(pictures, out):
    command_line.run("oiiotool", *pictures, "--mosaic:pad=4", f"{len(pictures)}x1", "-o", out)


def fields(options, folder):
    camera, out = (os.path.join(folder, name) for name in ("camera.json", "out.exr"))
    cloud = bench_phong.model_file("knot", folder)
    splats, clouds = bench_phong.fit_all(cloud, options.splats, folder)
    common = ["-o", out, "-q", "--size", f"{options.size}x{options.size}", "--background",
              "1,1,1,1", "--min-splat", "0", "--method", "two-pass", "--path", "compute"]
    run("render", cloud, *common, "--view", "20,62", "--write-camera", camera)
    ways = {name: (fitted, more) for name, fitted, more in bench_phong.WAYS}
    pictures = []
    for name in ("flat", "blended", "Phong"):
        fitted, more = ways[name]
        pictures.append(os.path.join(folder, f"{len(pictures)}.png"))
        run("render", clouds[fitted], *common, "--camera", camera, "--preview", pictures[-1], *more)
    side_by_side(pictures, options.out)
    print(f"{splats} splats")


def edges(options, folder):
    solid = bench_phong_edges.Mesh(*bench_phong_edges.generated(), 30)
    cloud, few, bare, camera, out = (os.path.join(folder, name) for name in
                                     ("cloud.ply", "few.ply", "bare.ply", "camera.json", "out.exr"))
    solid.sample(60000, cloud)
    splats, clipped = bench_phong_edges.fit(cloud, few, 0.0005 * solid.size, [])
    bench_phong_edges.without_lines(few, bare)
    pictures = []
    for source, zoom in [(few, 1), (few, ZOOM), (bare, ZOOM), (cloud, ZOOM)]:
        view = bench_phong_edges.View(solid, 35, 25, options.size)
        if zoom > 1:
            view.centre, view.step = CORNER, view.step / zoom
        view.write(camera)
        pictures.append(os.path.join(folder, f"{len(pictures)}.png"))
        run("render", source, "-o", out, "-q", "--camera", camera, "--preview", pictures[-1],
            "--size", f"{options.size}x{options.size}", "--method", "exact", "--min-splat", "0",
            "--cull", "back", "--background", "1,1,1,1")
    side_by_side(pictures, options.out)
    print(f"{splats} splats, {clipped} clipped")


def main():
    parser = command_line.Arguments(__doc__)
    parser.add_argument("what", choices=["fields", "edges"])
    parser.add_argument("out")
    parser.add_argument("--splats", type=command_line.positive, default=500)
    parser.add_argument("--size", type=command_line.positive, default=400)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        {"fields": fields, "edges": edges}[options.what](options, folder)


if __name__ == "__main__":
    main()
