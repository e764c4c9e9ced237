#!/usr/bin/env python3
"""The pictures of docs/transparency.md and docs/glass.md beside those of Zhang and Pajarola 2006; they
want oiiotool.

  tools/transparent_pictures.py ways OUT [--size PIXELS]
      Fig. 12: a transparent knot by depth peeling, by Algorithm 3 (nearest) and by Algorithm 2
      (fast); below, what each differs from the reference, four times as strong
  tools/transparent_pictures.py beads OUT [--size PIXELS]
      Figs. 1 a, b and 13: opaque balls within a transparent surface, by Algorithms 2 and 3, and by
      exact layers
  tools/transparent_pictures.py glass OUT [--size PIXELS]
      Figs. 1 c, d and 14: the knot of glass, single-layer and multi-layer
"""
import os
import sys
import tempfile

from command_line import Arguments, ROOT, positive, run, stipple

KNOT = os.path.join(ROOT, "assets", "knot.ply")
LOOK = ["--opacity", "0.4", "--background", "1,1,1,1", "--view", "30,25"]
WAYS = [["peel", "--peel-layers", "16"], ["nearest"], ["fast"]]


def render(size, out, way):
    """An EXR, and a PNG beside it."""
    stipple("render", KNOT, "-q", "--size", f"{size}x{size}", "-o", out + ".exr", "--preview",
                  out + ".png", *LOOK, "--transparency", *way)


def ways(folder, size, out):
    names = [os.path.join(folder, way[0]) for way in WAYS]
    truth = os.path.join(folder, "truth")
    render(size, truth, ["reference"])
    for name, way in zip(names, WAYS):
        render(size, name, way)
        run("oiiotool", name + ".exr", "--ch", "R,G,B", truth + ".exr", "--ch", "R,G,B", "--absdiff", "--mulc",
            "4", "-d", "uint8", "-o", name + "-off.png")
    mosaic([n + ".png" for n in names] + [n + "-off.png" for n in names], len(WAYS), out)


def mosaic(pictures, columns, out):
    rows = len(pictures) // columns
    run("oiiotool", *pictures, "--mosaic:pad=4", f"{columns}x{rows}", "--ch", "R,G,B", "-o", out)


def scenes(folder):
    maker = os.path.join(ROOT, "tools", "make_glass.py")
    run(sys.executable, maker, folder, "--model", KNOT)


def rendered(folder, scene, name, size, *more):
    picture = os.path.join(folder, name + ".png")
    stipple("render", os.path.join(folder, scene), "-q", "--size", f"{size}x{size}", "--preview",
                  picture, *more)
    return picture


def beads(folder, size, out):
    scenes(folder)
    ways_of_beads = ["fast", "nearest", "exact"]
    mosaic([rendered(folder, "beads.json", way, size, "--transparency", way, "--background", "1,1,1,1")
            for way in ways_of_beads], len(ways_of_beads), out)


def glass(folder, size, out):
    scenes(folder)
    look = ["--view", "30,25", "--transparency", "exact", "--samples", "4", "--background", "environment"]
    mosaic([rendered(folder, "glass.json", layers, size, "--layers", layers, *look)
            for layers in ["single", "multi"]], 2, out)


def main():
    parser = Arguments(__doc__)
    parser.add_argument("what", choices=["ways", "beads", "glass"])
    parser.add_argument("out")
    parser.add_argument("--size", type=positive, default=300)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        {"ways": ways, "beads": beads, "glass": glass}[options.what](folder, options.size, options.out)


if __name__ == "__main__":
    main()
