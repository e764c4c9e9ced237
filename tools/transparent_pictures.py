#!/usr/bin/env python3
"""The picture of docs/transparency.md beside Fig. 12 of Zhang and Pajarola 2006; it wants oiiotool.

  tools/transparent_pictures.py OUT [--size PIXELS]

A transparent knot by depth peeling, by Algorithm 3 (nearest) and by Algorithm 2 (fast); below, what
each differs from the reference, four times as strong.
"""
import argparse
import os
import subprocess
import tempfile

import bench

KNOT = os.path.join(bench.ROOT, "assets", "knot.ply")
LOOK = ["--opacity", "0.4", "--background", "1,1,1,1", "--view", "30,25"]
WAYS = [["peel", "--peel-layers", "16"], ["nearest"], ["fast"]]


def render(size, out, way):
    """An EXR, and a PNG beside it."""
    bench.stipple("render", KNOT, "-q", "--size", f"{size}x{size}", "-o", out + ".exr", "--preview",
                  out + ".png", *LOOK, "--transparency", *way)


def ways(folder, size, out):
    names = [os.path.join(folder, way[0]) for way in WAYS]
    truth = os.path.join(folder, "truth")
    render(size, truth, ["reference"])
    for name, way in zip(names, WAYS):
        render(size, name, way)
        subprocess.run(["oiiotool", name + ".exr", "--ch", "R,G,B", truth + ".exr", "--ch", "R,G,B",
                        "--absdiff", "--mulc", "4", "-d", "uint8", "-o", name + "-off.png"],
                       check=True)
    pictures = [n + ".png" for n in names] + [n + "-off.png" for n in names]
    mosaic = ["--mosaic:pad=4", f"{len(WAYS)}x2", "--ch", "R,G,B"]
    subprocess.run(["oiiotool", *pictures, *mosaic, "-o", out], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--size", type=int, default=300)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ways(folder, options.size, options.out)


if __name__ == "__main__":
    main()
