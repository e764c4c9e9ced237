#!/usr/bin/env python3
"""stipple-view on a virtual display, under validation: points and floor hide each other, the error of
exact is black and that of deferred is not, and what cannot be shown ends with one line.
usage: viewer.py STIPPLE-VIEW MODEL"""
import os
import subprocess
import sys
import tempfile

VIEW, MODEL = sys.argv[1:3]
SIZE = (320, 240)


def show(*arguments, scene=MODEL, display=True):
    command = [VIEW, scene, "--size", f"{SIZE[0]}x{SIZE[1]}", *arguments]
    if display:
        command = ["xvfb-run", "-a", "-s", "-screen 0 640x480x24", *command]
    env = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run(command, capture_output=True, text=True, env=env)


def picture(*arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "view.ppm")
        run = show("--frames", "2", "--validate", "--save", path, *arguments)
        assert run.returncode == 0, run.stderr
        with open(path, "rb") as file:
            data = file.read()
    header = b"P6\n%d %d\n255\n" % SIZE
    assert data.startswith(header), data[:20]
    body = data[len(header):]
    return [tuple(body[i:i + 3]) for i in range(0, len(body), 3)]


def is_gray(p):
    """The background and both fields of the floor: bluish grays."""
    return max(p) - min(p) < 16 and p[0] <= p[2]


def is_off(p):
    """An error of 1e-3: 16 times that, twice for the red half of the scale, in sRGB."""
    return p[0] > 50


def share(pixels, test):
    return sum(map(test, pixels)) / len(pixels)


def main():
    with_floor, without = picture("--method", "two-pass raster"), picture("--no-floor")
    points = share(without, lambda p: not is_gray(p))
    covered = share(with_floor, lambda p: not is_gray(p))
    floor = share(with_floor, lambda p: is_gray(p) and p[0] > 100)
    assert 0.05 < covered < points - 0.005, (covered, points)  # the floor hides some points
    assert floor > 0.2, floor
    assert share(picture("--error"), is_off) < 0.002
    assert share(picture("--error", "--method", "deferred"), is_off) > 0.01
    for run, words in [(show("--method", "none"), 'no method "none"'),
                       (show(scene="/nonexistent.ply"), "/nonexistent.ply"),
                       (show(display=False), "no display")]:
        assert run.returncode == 1 and words in run.stderr, run.stderr
    print("7 checked, 0 at fault")


main()
