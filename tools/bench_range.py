#!/usr/bin/env python3
"""Range images with one frame left out, as Markdown.

  tools/bench_range.py --kinect DIR --aloe DIR [--merge blend|sort]
  tools/bench_range.py --kinect DIR --pictures OUT

kinect: a folder of range images (docs/range.md). Each frame in turn is left out and drawn from the
others, at its own camera. aloe: a stereo pair (aloeL, aloeR, disparities aloeGT.png of the left); the
right picture is drawn from the left. PSNR, linear light, over the pixels that every picture of a row
covers (alpha of a half or more); needs oiiotool. docs/results/range.md was made with it.
pictures: in their place range_discs.jpg and range_ellipsoids.jpg into the folder OUT, all frames from a
view that none has: half way from the second to the third, a quarter of a metre to the right.
"""
import array
import json
import math
import os
import struct
import tempfile

from command_line import Arguments, existing, run, stipple

LINEAR = [v / 255 / 12.92 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in range(256)]
FULL = [("discs", ["--range-splats", "discs"]),
        ("ellipsoids, exact depths", ["--uncertainty", "0"]),
        ("ellipsoids", []),
        ("ellipsoids, colours by views", ["--color-by", "views"])]
MARGIN = 8  # pixels: these colour pictures end in a white border, where rectifying them found nothing
# Middlebury 2006, full size: focal length and baseline in pixels and metres, disparities of the crops.
ALOE = {"fx": 3740.0, "baseline": 0.160, "offset": 270.0,
        "sigma": 1 / math.sqrt(12)}  # measured to less than a pixel, then rounded to whole ones


def oiiotool(*arguments):
    run("oiiotool", *arguments)


def read_exr(path):
    """Rows of every channel of an uncompressed scan-line EXR of 32-bit channels."""
    with open(path, "rb") as file:
        data = file.read()
    at, names, window = 8, [], None
    while data[at]:
        name, _, rest = data[at:at + 64].partition(b"\0")
        kind = rest.split(b"\0")[0]
        at += len(name) + len(kind) + 2
        size = int.from_bytes(data[at:at + 4], "little")
        value, at = data[at + 4:at + 4 + size], at + 4 + size
        if name == b"dataWindow":
            window = struct.unpack("<4i", value)
        while name == b"channels" and value[0]:
            channel, _, value = value.partition(b"\0")
            names.append(channel.decode())
            assert value[:4] == b"\2\0\0\0", "floats are needed"
            value = value[16:]
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    at += 1 + 8 * height
    rows = {name: [] for name in names}
    for y in range(height):
        start = at + y * (8 + 4 * width * len(names)) + 8
        for i, name in enumerate(names):
            line = array.array("f")
            line.frombytes(data[start + 4 * width * i:start + 4 * width * (i + 1)])
            rows[name].append(line)
    return rows


def picture(path, folder):
    """An 8-bit sRGB picture as rows of linear floats."""
    out = os.path.join(folder, "picture.ppm")
    oiiotool(path, "--ch", "R,G,B", "-d", "uint8", "-o", out)
    with open(out, "rb") as file:
        data = file.read()
    head = data.split(None, 4)
    width, height = int(head[1]), int(head[2])
    body = data[len(data) - width * height * 3:]
    return [array.array("f", (LINEAR[v] for v in body[y * width * 3:(y + 1) * width * 3]))
            for y in range(height)]


class Drawn:
    """A render: straight linear colour, and where it covers."""

    def __init__(self, path):
        planes = read_exr(path)
        self.covers = [bytes(1 if a >= 0.5 else 0 for a in row) for row in planes["A"]]
        self.rgb = []
        for alpha, *colors in zip(planes["A"], planes["R"], planes["G"], planes["B"]):
            row = array.array("f", bytes(12 * len(alpha)))
            for i, color in enumerate(colors):
                row[i::3] = array.array("f", (c / a if a >= 0.5 else 0
                                              for c, a in zip(color, alpha)))
            self.rgb.append(row)


def psnr(truth, drawn, mask):
    total = count = 0
    for want, got, use in zip(truth, drawn.rgb, mask):
        for x, used in enumerate(use):
            if used:
                count += 3
                for i in range(3 * x, 3 * x + 3):
                    total += (want[i] - got[i]) ** 2
    return -10 * math.log10(total / count) if total else math.inf, count // 3


def common(pictures, margin):
    masks = [p.covers for p in pictures]
    rows = [bytes(min(column) for column in zip(*rows)) for rows in zip(*masks)]
    width, height = len(rows[0]), len(rows)
    inside = bytes(1 if margin <= x < width - margin else 0 for x in range(width))
    return [bytes(map(min, row, inside)) if margin <= y < height - margin else bytes(width)
            for y, row in enumerate(rows)]


def poses(folder):
    with open(os.path.join(folder, "pose.txt"), encoding="utf-8") as file:
        return [[float(v) for v in line.split()] for line in file if line.strip()]


def intrinsics(folder):
    with open(os.path.join(folder, "intrinsics.txt"), encoding="utf-8") as file:
        pairs = [line.split() for line in file if line.strip() and not line.startswith("#")]
    return {key: float(value) for key, value in pairs}


def half_pixels(lens):
    """From centres of pixels at whole numbers to camera files', at +0.5."""
    return {"fx": lens["fx"], "fy": lens["fy"], "cx": lens["cx"] + 0.5, "cy": lens["cy"] + 0.5}


def camera(pose, lens, size):
    """A camera file of a camera-to-world pose."""
    tx, ty, tz, x, y, z, w = pose
    n = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    r = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    m = [[r[k][i] for k in range(3)] + [-sum(r[k][i] * t for k, t in enumerate((tx, ty, tz)))]
         for i in range(3)]
    return {"world_to_camera": m + [[0, 0, 0, 1]], "convention": "opencv", "width": size[0],
            "height": size[1], "intrinsics": lens}


def write(path, value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file)
    return path


def render(scene, view, out, more, merge):
    method = ["--method", "exact"] if "discs" in more else ["--axis-merge", merge]
    stipple("render", scene, "--camera", view, "-o", out, "-q", "--compression", "none", *method, *more)
    return out


def draw_all(scene, view, folder, merge, configs):
    out = os.path.join(folder, "out.exr")
    return [Drawn(render(scene, view, out, more, merge)) for _, more in configs]


def kinect_scene(source, numbers, path):
    pose = poses(source)
    frames = [{"depth": f"{source}/depth/{n + 1}.pgm", "color": f"{source}/color/{n + 1}.png",
               "pose": pose[n]} for n in numbers]
    return write(path, {"range": {"intrinsics_file": f"{source}/intrinsics.txt", "margin": MARGIN,
                                  "frames": frames}})


def nearest(pose, left):
    return min((n for n in range(len(pose)) if n != left),
               key=lambda n: math.dist(pose[n][:3], pose[left][:3]))


def kinect(source, merge, folder):
    pose, lens = poses(source), half_pixels(intrinsics(source))
    names = [name for name, _ in FULL] + ["nearest view alone"]
    print("| left out | pixels | " + " | ".join(names) + " |")
    print("| --- | ---: |" + " ---: |" * len(names))
    totals = [0.0] * len(names)
    for left in range(len(pose)):
        truth = picture(f"{source}/color/{left + 1}.png", folder)
        view = write(os.path.join(folder, "view.json"),
                     camera(pose[left], lens, (len(truth[0]) // 3, len(truth))))
        others = kinect_scene(source, [n for n in range(len(pose)) if n != left],
                              os.path.join(folder, "others.json"))
        one = kinect_scene(source, [nearest(pose, left)], os.path.join(folder, "one.json"))
        drawn = draw_all(others, view, folder, merge, FULL)
        drawn += draw_all(one, view, folder, merge, [("nearest", ["--range-splats", "discs"])])
        row(str(left + 1), truth, drawn, MARGIN, totals)
    print("| mean | | " + " | ".join(f"{t / len(pose):.2f}" for t in totals) + " |")


def row(name, truth, drawn, margin, totals=None):
    mask, figures = common(drawn, margin), []
    for i, one in enumerate(drawn):
        value, count = psnr(truth, one, mask)
        figures.append(value)
        if totals:
            totals[i] += value
    print(f"| {name} | {count} | " + " | ".join(f"{v:.2f}" for v in figures) + " |", flush=True)


def aloe(source, merge, folder):
    left, right = (os.path.join(folder, f"{side}.png") for side in ("left", "right"))
    oiiotool(os.path.join(source, "aloeL.jpg"), "-o", left)
    oiiotool(os.path.join(source, "aloeR.jpg"), "-o", right)
    truth = picture(right, folder)
    width, height = len(truth[0]) // 3, len(truth)
    lens = {"fx": ALOE["fx"], "fy": ALOE["fx"], "cx": width / 2, "cy": height / 2}
    frame = {"depth": os.path.join(source, "aloeGT.png"), "color": left,
             "pose": [0, 0, 0, 0, 0, 0, 1]}
    scene = write(os.path.join(folder, "aloe.json"), {"range": {
        "intrinsics": lens, "frames": [frame],
        "disparity": {"baseline": ALOE["baseline"], "offset": ALOE["offset"]},
        "sensor": {"type": "stereo", "sigma_disparity": ALOE["sigma"]}}})
    # The pair is cropped, so that the right picture's axis lies `offset` pixels further to the right.
    shifted = dict(lens, cx=lens["cx"] + ALOE["offset"])
    view = write(os.path.join(folder, "view.json"),
                 camera([ALOE["baseline"], 0, 0, 0, 0, 0, 1], shifted, (width, height)))
    print("| drawn | pixels | " + " | ".join(name for name, _ in FULL[:3]) + " |")
    print("| --- | ---: |" + " ---: |" * 3)
    row("right from left", truth, draw_all(scene, view, folder, merge, FULL[:3]), 0)


def aside(pose, metres):
    """The same view, moved to its right."""
    right = camera(pose, {}, (0, 0))["world_to_camera"][0]
    return [p + metres * r for p, r in zip(pose[:3], right)] + pose[3:]


def pictures(source, merge, folder, out):
    pose, lens = poses(source), half_pixels(intrinsics(source))
    between = aside([(a + b) / 2 for a, b in zip(pose[1], pose[2])], 0.25)
    view = write(os.path.join(folder, "view.json"), camera(between, lens, (640, 480)))
    scene = kinect_scene(source, range(len(pose)), os.path.join(folder, "all.json"))
    for name, more in (("discs", ["--range-splats", "discs"]), ("ellipsoids", [])):
        drawn = render(scene, view, os.path.join(folder, "out.exr"), ["--size", "480x360", *more], merge)
        oiiotool(drawn, "--ch", "R,G,B", "--colorconvert", "linear", "sRGB", "-d", "uint8",
                 "--compression", "jpeg:90", "-o", os.path.join(out, f"range_{name}.jpg"))


def main():
    parser = Arguments(__doc__)
    parser.add_argument("--kinect", type=existing, help="a folder of range images")
    parser.add_argument("--aloe", type=existing, help="a folder of aloeL.jpg, aloeR.jpg and aloeGT.png")
    parser.add_argument("--pictures", metavar="OUT", help="a folder for pictures of the room")
    parser.add_argument("--merge", default="blend", choices=["blend", "clip", "single", "sort"])
    arguments = parser.parse_args()
    if not arguments.kinect and not arguments.aloe:
        parser.error("--kinect or --aloe says what to draw")
    if arguments.pictures and not arguments.kinect:
        parser.error("--pictures: of the frames that --kinect names")
    with tempfile.TemporaryDirectory() as folder:
        if arguments.kinect and arguments.pictures:
            pictures(os.path.abspath(arguments.kinect), arguments.merge, folder, arguments.pictures)
        elif arguments.kinect:
            print("\nKinect room, each frame from the others, dB\n")
            kinect(os.path.abspath(arguments.kinect), arguments.merge, folder)
        if arguments.aloe:
            print("\nAloe, the right picture from the left, dB\n")
            aloe(os.path.abspath(arguments.aloe), arguments.merge, folder)


if __name__ == "__main__":
    main()
