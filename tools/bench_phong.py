#!/usr/bin/env python3
"""Botsch, Spernat and Kobbelt's comparison on models of your own, as Markdown (docs/phong.md).

  tools/bench_phong.py curve MODEL... [--counts N,N...|--tolerances T,T...] [--view AZ,EL] [--method M]
  tools/bench_phong.py limit MODEL... [--counts N,N...]
  tools/bench_phong.py frames MODEL... [--counts N,N...] [--rounds N]
  tools/bench_phong.py fit MODEL... [--counts N,N...] [--rounds N]

A model is a file, or a smooth shape of 400,000 points: sphere, torus, cushion
(x^4 + y^4 + z^4 = 1), knot. All splats are made by `stipple prepare --fit-count`, the constant ones of
the same patches, and drawn with the epsilon of their fit. An error is the mean absolute difference
of linear RGB over covered pixels, 1024 x 1024, against the picture of the whole cloud.

curve: the error by the number of splats, of: Phong (linear fields fitted together, averaged, shaded
once: our default), the same with every field fitted alone (the paper's Eq. 3 and 4 as they stand),
averaged (constant normals fitted together, averaged, shaded once: the default of discs), the same
shaded, then blended, blended (constant normals, each alone, shaded, then blended: what the paper
compares with), flat (the nearest splat's normal, nothing blended). The last row is of the points
themselves, unfitted: the truth is their averaged picture, so that theirs is the error of the shading
alone. Then how many constant splats reach the error of each number of Phong splats; "above" all
points: not even those do. exponent: the error falls as the count to this power, between the least and
the most splats.
limit: what round splats of so many points can do at best, whatever made them and blended with
nothing: the angle, root mean square, between the normals of a point's nearest neighbours and the
linear field, and the constant normal, that is nearest to them; and how many constant splats have the
angle of a linear one. frames: milliseconds of a warm frame of Phong splats, and of as many blended
ones as have the same error. fit: points a second. Times are the medians of the rounds. Edges:
tools/bench_phong_edges.py.
"""
import json
import math
import os
import random
import re
import statistics
import struct
import tempfile

import bench_phong_limit
import command_line
import make_model



# Smooth shapes: position and normal of two numbers in [0, 1).
def on_sphere(a, b):
    z, angle = 2 * a - 1, 2 * math.pi * b
    r = math.sqrt(1 - z * z)
    n = (r * math.cos(angle), r * math.sin(angle), z)
    return n, n


def on_torus(a, b):
    """Not even in area: by angles."""
    u, v = 2 * math.pi * a, 2 * math.pi * b
    n = (math.cos(u) * math.cos(v), math.sin(u) * math.cos(v), math.sin(v))
    return (math.cos(u) + 0.4 * n[0], math.sin(u) + 0.4 * n[1], 0.4 * n[2]), n


def on_cushion(a, b):
    d, _ = on_sphere(a, b)
    length = sum(x ** 4 for x in d) ** 0.25
    p = tuple(x / length for x in d)
    slope = math.sqrt(sum(x ** 6 for x in p))
    return p, tuple(x ** 3 / slope for x in p)


def on_knot(a, b):
    """A tube round a (2, 3) torus knot, as make_model's without its scales; not even in area."""
    t, v = 2 * math.pi * a, 2 * math.pi * b
    out, side = make_model.frame(t)
    n = tuple(math.cos(v) * x + math.sin(v) * y for x, y in zip(out, side))
    return make_model.add(make_model.knot(t), n, make_model.TUBE), n


SHAPES = {"sphere": on_sphere, "torus": on_torus, "cushion": on_cushion, "knot": on_knot}
SHAPE_POINTS = 400000


def model_file(model, folder):
    """The file itself; of a shape, one that is written."""
    if model not in SHAPES:
        return model
    path, dice = os.path.join(folder, model + ".ply"), random.Random(1)
    with open(path, "wb") as out:
        out.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % SHAPE_POINTS)
        out.write(b"".join(b"property double %c\n" % c for c in b"xyz"))
        out.write(b"".join(b"property float n%c\n" % c for c in b"xyz") + b"end_header\n")
        for _ in range(SHAPE_POINTS):
            p, n = SHAPES[model](dice.random(), dice.random())
            out.write(struct.pack("<3d3f", *p, *n))
    return path


def run(*arguments):
    return command_line.run(command_line.STIPPLE, *arguments)


def fit(file, size, out, more=()):
    """The splats that came out, and the tolerance that it took. size: a count, or as text a
    tolerance."""
    way = "--fit" if isinstance(size, str) else "--fit-count"
    told = run("prepare", file, "-o", out, way, str(size), *more)
    found = re.search(r"-> (\d+) splats, tolerance ([^,]+),", told.stderr)
    return int(found[1]), found[2]


def fit_all(file, count, folder):
    """The same patches fitted each way of WAYS: splats, and files by the options of the fit."""
    clouds, splats = {}, 0
    for _, options, _ in WAYS:
        out = os.path.join(folder, "few" + "".join(options) + ".ply")
        if not clouds:
            splats, tolerance = fit(file, count, out, options)
        elif options not in clouds:
            run("prepare", file, "-o", out, "--fit", tolerance, *options)
        clouds[options] = out
    return splats, clouds


def scene_of(file, arguments, folder):
    """The file, of the material that was asked for."""
    if not arguments.material:
        return file
    path = os.path.join(folder, "scene.json")
    with open(path, "w") as out:
        material = dict(zip(("ambient", "diffuse", "specular", "shininess"), arguments.material))
        json.dump({"points": [{"file": os.path.abspath(file), "material": material}]}, out)
    return path


def render(file, arguments, out, camera, more=()):
    scene = scene_of(file, arguments, os.path.dirname(out))
    run("render", scene, "-o", out, "-q", "--size", "1024x1024", "--camera", camera,
        "--method", arguments.method, "--min-splat", "0", *more)


def render_truth(file, arguments, folder):
    """truth.exr, and camera.json for all others: left to itself, each would be framed by the extent
    of its own splats."""
    truth, camera = (os.path.join(folder, n) for n in ("truth.exr", "camera.json"))
    scene = scene_of(file, arguments, folder)
    run("render", scene, "-o", truth, "-q", "--size", "1024x1024", "--view", arguments.view,
        "--method", arguments.method, "--min-splat", "0", "--write-camera", camera)
    return truth, camera


def error(a, b):
    return json.loads(run("compare", "--json", a, b).stdout)["covered"]["mean_absolute"]


# Name, options of the fit, options of the render.
ALONE, FLAT, FLAT_ALONE = ("--fit-alone",), ("--fit-flat",), ("--fit-flat", "--fit-alone")
BLENDED = ("blended", FLAT_ALONE, ["--shade", "splat"])
WAYS = [
    ("Phong", (), []),
    ("Phong, alone", ALONE, []),
    ("averaged", FLAT, []),
    ("blended, together", FLAT, ["--shade", "splat"]),
    BLENDED,
    ("flat", FLAT_ALONE, ["--shade", "flat", "--path", "compute"]),
]


def measure(file, arguments, folder):
    """Rows of way -> (splats, error), a count; and that of the points. Each picture has the epsilon
    of its fit."""
    out = os.path.join(folder, "out.exr")
    truth, camera = render_truth(file, arguments, folder)
    rows = []
    for count in arguments.counts:
        splats, clouds = fit_all(file, count, folder)
        row = {}
        for name, options, more in WAYS:
            render(clouds[options], arguments, out, camera, more)
            row[name] = (splats, error(out, truth))
        rows.append(row)
    return rows, measure_points(file, arguments, folder)


def measure_points(file, arguments, folder):
    """way -> (points, error), of the ways that are not the truth's."""
    out, truth, camera = (os.path.join(folder, n) for n in ("out.exr", "truth.exr", "camera.json"))
    points = json.loads(run("info", "--json", file).stdout)[0]["splats"]
    row = {}
    for name, _, more in (BLENDED, WAYS[-1]):
        render(file, arguments, out, camera, more)
        row[name] = (points, error(out, truth))
    return row


def reaching(rows, name, wanted):
    """The splats with which `name` comes down to the error, by interpolation in logarithms; None:
    not within the counts."""
    for few, many in zip(rows, rows[1:]):
        (n, a), (m, b) = few[name], many[name]
        if b <= wanted <= a and a > b:
            share = math.log(a / wanted) / math.log(a / b)
            return n * (m / n) ** share
    return None


def exponent(rows, name):
    (few, a), (many, b) = rows[0][name], rows[-1][name]
    return math.log(b / a) / math.log(many / few) if many > few else math.nan


def equal_cell(rows, points, name, splats, wanted):
    count = reaching(rows, name, wanted)
    if count:
        return f"{count:.0f} ({count / splats:.1f} x)"
    most, least = rows[-1][name], rows[0][name]
    if name in points and points[name][1] > wanted:
        most = points[name]
    return f"above {most[0]} (> {most[0] / splats:.1f} x)" if most[1] > wanted else f"below {least[0]}"


def print_curve(file, fitted, points):
    names = list(fitted[0])
    print(f"\n{os.path.basename(file)}, error\n\n| splats | {' | '.join(names)} |")
    print("|---" * (len(names) + 1) + "|")
    for row in fitted:
        print(f"| {row['Phong'][0]} | {' | '.join(f'{row[n][1]:.5f}' for n in names)} |")
    cells = [f"{points[n][1]:.5f}" if n in points else "" for n in names]
    print(f"| the {points['flat'][0]} points | {' | '.join(cells)} |")
    print(f"| exponent | {' | '.join(f'{exponent(fitted, n):.2f}' for n in names)} |")
    print(f"\n{os.path.basename(file)}, splats for equal error\n\n| {' | '.join(names)} |")
    print("|---" * len(names) + "|", flush=True)
    for row in fitted:
        splats, wanted = row["Phong"]
        cells = [equal_cell(fitted, points, name, splats, wanted) for name in names[1:]]
        print(f"| {splats} | {' | '.join(cells)} |", flush=True)


def curve(arguments):
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.model:
            print_curve(model, *measure(model_file(model, folder), arguments, folder))


def limits(arguments):
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.model:
            bench_phong_limit.print_limits(os.path.basename(model), model_file(model, folder),
                                           arguments.counts)


def frame_ms(cloud, arguments, folder, more):
    stats = os.path.join(folder, "stats.json")
    render(cloud, arguments, os.path.join(folder, "out.exr"), os.path.join(folder, "camera.json"),
           ["--repeat", "10", "--stats", stats, *more])
    with open(stats) as text:
        return json.load(text)["frame_ms"]["median"]


def fit_to_error(file, arguments, folder, way, wanted, start):
    """Constant splats, in few.ply, that come to the error, within 3 %: how many, and their error.
    A secant in logarithms: the error falls about as a power of the count."""
    name, options, more = way
    cloud, out, truth, camera = (os.path.join(folder, n) for n in
                                 (name + ".ply", "out.exr", "truth.exr", "camera.json"))
    tried, count = [], start
    for _ in range(6):
        splats = fit(file, round(count), cloud, options)[0]
        render(cloud, arguments, out, camera, more)
        tried.append((math.log(splats), math.log(error(out, truth) / wanted)))
        if abs(tried[-1][1]) < 0.03:
            break
        slope = -0.5
        if len(tried) > 1 and tried[-1][0] != tried[-2][0]:
            slope = min(-0.1, (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0]))
        count = math.exp(tried[-1][0] - max(-2, min(2, tried[-1][1] / slope)))
    return round(math.exp(tried[-1][0])), wanted * math.exp(tried[-1][1])


def frames(arguments):
    """Rounds are interleaved: Phong, then blended, and again."""
    print("| model | splats, Phong | error | ms | splats, blended | error | ms | blended / Phong |")
    print("|---" * 8 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.model:
            file = model_file(model, folder)
            few = os.path.join(folder, "few.ply")
            out = os.path.join(folder, "out.exr")
            truth, camera = render_truth(file, arguments, folder)
            for count in arguments.counts:
                phong = fit(file, count, few)[0]
                render(few, arguments, out, camera)
                wanted = error(out, truth)
                many, reached = fit_to_error(file, arguments, folder, BLENDED, wanted, 4 * count)
                times = {few: [], os.path.join(folder, "blended.ply"): []}
                for _ in range(arguments.rounds):
                    for cloud in times:
                        more = [] if cloud == few else BLENDED[2]
                        times[cloud].append(frame_ms(cloud, arguments, folder, more))
                a, b = (statistics.median(t) for t in times.values())
                print(f"| {os.path.basename(model)} | {phong} | {wanted:.5f} | {a:.1f} | {many} | "
                      f"{reached:.5f} | {b:.1f} | {b / a:.2f} |", flush=True)


def fits(arguments):
    print("| model | splats | points a second |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.model:
            file = model_file(model, folder)
            for count in arguments.counts:
                told = run("prepare", file, "-o", os.path.join(folder, "few.ply"), "--fit-count",
                           str(count)).stderr
                tolerance = re.search(r"tolerance (\S+),", told)[1]
                rates = []
                for _ in range(arguments.rounds):
                    told = run("prepare", file, "-o", os.path.join(folder, "few.ply"), "--fit",
                               tolerance).stderr
                    found = re.search(r"(\d+) points -> (\d+) splats.* (\d+) ms", told)
                    rates.append(1e3 * int(found[1]) / float(found[3]))
                print(f"| {os.path.basename(model)} | {found[2]} | {statistics.median(rates):.0f} |")


def main():
    parser = command_line.Arguments(__doc__)
    parser.add_argument("what", choices=["curve", "limit", "frames", "fit"])
    parser.add_argument("model", nargs="+")
    parser.add_argument("--counts", type=lambda text: [int(n) for n in text.split(",")],
                        help="default: 1000,3000,10000,30000,100000; frames: 3000,10000")
    parser.add_argument("--tolerances", type=lambda text: text.split(","),
                        help="curve: in the place of the counts, which take a search each")
    parser.add_argument("--material", type=lambda text: [float(x) for x in text.split(",")],
                        help="ambient,diffuse,specular,shininess; default: 0.1,0.7,0.2,32")
    parser.add_argument("--view", default="35,15")
    parser.add_argument("--method", default="two-pass")
    parser.add_argument("--rounds", type=command_line.positive, default=5)
    arguments = parser.parse_args()
    for model in arguments.model:
        if model not in SHAPES and not os.path.exists(model):
            parser.error(f"{model}: no such file, and none of {', '.join(SHAPES)}")
    if arguments.tolerances and arguments.what != "curve":
        parser.error("--tolerances is of curve")
    if arguments.tolerances:
        arguments.counts = arguments.tolerances
    elif not arguments.counts:
        few = arguments.what == "frames"
        arguments.counts = [3000, 10000] if few else bench_phong_limit.COUNTS
    {"curve": curve, "limit": limits, "frames": frames, "fit": fits}[arguments.what](arguments)


if __name__ == "__main__":
    main()
