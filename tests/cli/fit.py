#!/usr/bin/env python3
"""prepare --fit: the file is read back here, and what it holds compared with the points; then it
is rendered beside them. And prepared files in general: they give the picture of their source."""
import json
import re
import struct

import command

VIEW = ["--size", "96x96", "--view", "35,20", "--method", "reference"]
SIZES = {"double": "d", "float": "f", "uint": "I", "ushort": "H", "uchar": "B"}


def cube(side=24):
    """Positions and normals of the faces of [-1, 1]^3, none on an edge."""
    rows = []
    for axis in range(3):
        for sign in (-1, 1):
            for i in range(side * side):
                p = [0, 0, 0]
                p[axis], n = sign, [0, 0, 0]
                p[axis - 1] = (2 * (i % side) + 1) / side - 1
                p[axis - 2] = (2 * (i // side) + 1) / side - 1
                n[axis] = sign
                rows.append((p, n))
    return rows


def ply_of(rows, colors=None):
    names = "x y z nx ny nz".split() + (["red", "green", "blue"] if colors else [])
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(rows)
    header += "".join("property float %s\n" % name for name in names) + "end_header\n"
    return header.encode() + b"".join(
        struct.pack("<%df" % len(names), *p, *n, *(colors[i] if colors else ()))
        for i, (p, n) in enumerate(rows))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def covers(splat, point, tolerance):
    """BSK Eq. 1 and the clip lines, by code of its own."""
    n, u = [splat["n" + c] for c in "xyz"], [splat["tangent_" + c] for c in "xyz"]
    d = [p - splat[c] for p, c in zip(point, "xyz")]
    v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
    s, t = dot(d, u) / splat["radius_u"], dot(d, v) / splat["radius_v"]
    lines = int(splat.get("clip_count", 0))
    kept = [splat["clip_%d_a" % i] * s + splat["clip_%d_b" % i] * t + splat["clip_%d_c" % i] >= 0
            for i in range(lines)]
    clipped = lines and not (any(kept) if splat["clip_reflex"] else all(kept))
    return s * s + t * t <= 1 and abs(dot(d, n)) <= tolerance and not clipped


class Fit(command.CommandTest):
    def fit(self, source, out, *options):
        """The splats that the line on stderr tells of, and the tolerance."""
        run = self.run_tool("prepare", source, "-o", out, *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        found = re.fullmatch(r"(\d+) points -> (\d+) splats, tolerance (\S+), deviation (\S+), "
                             r"\d+ of one point, (\d+) clipped, \d+ ms\n", run.stderr)
        self.assertIsNotNone(found, run.stderr)
        self.assertLessEqual(float(found[4]), float(found[3]) * 1.00001)
        return int(found[2]), float(found[3]), int(found[5])

    def splats(self, name):
        """A dictionary a splat, and the words of the comments about objects."""
        head, body = self.read(name).split(b"end_header\n", 1)
        head = head.decode()
        count = int(re.search(r"element vertex (\d+)", head)[1])
        properties = re.findall(r"property (\w+) (\w+)", head)
        rows = list(struct.iter_unpack("<" + "".join(SIZES[kind] for kind, _ in properties), body))
        self.assertEqual(len(rows), count)
        comments = re.findall(r"^comment stipple object (.*)$", head, re.M)
        return [dict(zip((p for _, p in properties), row)) for row in rows], comments

    def compare(self, a, b):
        return self.done_json("compare", "--json", a, b)

    def test_every_point_is_covered(self):
        told, tolerance, _ = self.fit("ball.ply", "few.ply", "--fit", "0.01")
        splats, comments = self.splats("few.ply")
        self.assertEqual((len(splats), tolerance), (told, 0.01))
        self.assertLess(told, 400)
        for point in command.sphere():
            self.assertTrue(any(covers(s, point, 0.0100001) for s in splats), point)
        self.assertTrue(all(s["field_1"] and s["field_3"] for s in splats))
        self.assertEqual(len(comments), 1)
        epsilon = float(comments[0].split()[2])
        self.assertGreaterEqual(epsilon, 0.04)
        facts = self.done_json("info", "--json", "few.ply")[0]
        self.assertEqual((facts["splats"], facts["ellipses"]), (told, told))

    def test_count(self):
        for wanted in (60, 300):
            told, _, _ = self.fit("ball.ply", "few.ply", "--fit-count", str(wanted))
            self.assertLessEqual(told, wanted)
            self.assertGreaterEqual(told, 0.9 * wanted)
            self.assertEqual(len(self.splats("few.ply")[0]), told)

    def test_threads(self):
        self.fit("ball.ply", "few.ply", "--fit-count", "100", "--threads", "1")
        one = self.read("few.ply")
        self.fit("ball.ply", "few.ply", "--fit-count", "100", "--threads", "5")
        self.assertEqual(self.read("few.ply"), one)

    def test_flat(self):
        self.fit("ball.ply", "few.ply", "--fit-count", "100", "--fit-flat")
        splats, _ = self.splats("few.ply")
        self.assertFalse(any(s["field_1"] or s["field_3"] for s in splats))

    def test_alone(self):
        """The same ellipses, other fields."""
        self.fit("ball.ply", "few.ply", "--fit", "0.01")
        self.fit("ball.ply", "alone.ply", "--fit", "0.01", "--fit-alone")
        few, alone = self.splats("few.ply")[0], self.splats("alone.ply")[0]
        self.assertEqual(len(few), len(alone))
        pairs = list(zip(few, alone))
        for one, other in pairs:
            self.assertEqual([one[n] for n in ("x", "y", "z", "radius_u", "radius_v")],
                             [other[n] for n in ("x", "y", "z", "radius_u", "radius_v")])
        self.assertTrue(any(one["field_1"] != other["field_1"] for one, other in pairs))

    def test_clipped(self):
        """A cube's splats end at its edges; --fit-smooth looks for none."""
        rows = cube()
        self.write("cube.ply", ply_of(rows))
        told, _, clipped = self.fit("cube.ply", "few.ply", "--fit", "0.01")
        splats, _ = self.splats("few.ply")
        self.assertEqual(sum(s["clip_count"] > 0 for s in splats), clipped)
        self.assertGreater(clipped, 12)
        for point, _ in rows[::7]:
            self.assertTrue(any(covers(s, point, 0.0100001) for s in splats), point)
        self.assertEqual(self.fit("cube.ply", "smooth.ply", "--fit", "0.01", "--fit-smooth")[2], 0)
        self.assertNotIn(b"clip_count", self.read("smooth.ply"))

    def test_colors(self):
        """Splats keep to one side of a border of colours, unless that is asked not to matter."""
        points = command.sphere()
        colors = [(1, 0, 0) if p[0] < 0.1 else (0, 0, 1) for p in points]
        self.write("two.ply", ply_of([(p, p) for p in points], colors))
        self.fit("two.ply", "few.ply", "--fit", "0.02")
        for s in self.splats("few.ply")[0]:
            self.assertIn((s["red"], s["green"], s["blue"]), [(1, 0, 0), (0, 0, 1)])
        self.fit("two.ply", "few.ply", "--fit", "0.02", "--fit-color", "1")
        self.assertTrue(any(0 < s["red"] < 1 for s in self.splats("few.ply")[0]))

    def test_picture(self):
        """Of a tenth of the splats, against that of all points; constant normals lose far more."""
        self.done("render", "ball.ply", "-o", "all.exr", *VIEW, "--write-camera", "camera.json")
        view = [*VIEW[:2], *VIEW[4:], "--camera", "camera.json"]
        self.fit("ball.ply", "few.ply", "--fit-count", "200")
        self.done("render", "few.ply", "-o", "few.exr", *view)
        error = self.compare("few.exr", "all.exr")
        self.assertGreater(error["covered"]["psnr"], 33)
        self.assertLess(error["normal_mean"], 1)
        self.fit("ball.ply", "flat.ply", "--fit-count", "200", "--fit-flat")
        self.done("render", "flat.ply", "-o", "flat.exr", *view)
        flat = self.compare("flat.exr", "all.exr")
        self.assertLess(error["normal_mean"], flat["normal_mean"] / 3)

    def test_epsilon_of_the_file(self):
        """The epsilon that the fit found is that of the picture: thin things keep their sides."""
        self.fit("ball.ply", "few.ply", "--fit-count", "60")
        epsilon = self.splats("few.ply")[1][0].split()[2]
        radii = sorted(s["radius"] for s in self.splats("few.ply")[0])
        self.assertLess(float(epsilon), 0.7 * radii[len(radii) // 2])
        self.done("render", "few.ply", "-o", "own.exr", *VIEW)
        self.done("render", "few.ply", "-o", "said.exr", *VIEW, "--epsilon", epsilon)
        self.assertEqual(self.compare("own.exr", "said.exr")["all"]["maximum"], 0)

    def test_prepared_objects(self):
        """Of a scene whose objects differ in epsilon, albedo and whether they brought normals."""
        self.write("bare.xyz", "".join("%.6f %.6f %.6f\n" % p for p in command.sphere(900, 0.6)))
        scale = 0.7
        entries = [{"file": "ball.ply", "epsilon": 0.5,
                    "transform": [scale, 0, 0, 0.5, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1]},
                   {"file": "bare.xyz", "material": {"albedo": [0.9, 0.2, 0.1]}}, "ball.ply"]
        self.write("scene.json", json.dumps({"points": entries}))
        self.done("prepare", "scene.json", "-o", "all.ply")
        for cull in ("back", "none"):
            for name in ("scene.json", "all.ply"):
                self.done("render", name, "-o", name + ".exr", *VIEW, "--cull", cull)
            error = self.compare("scene.json.exr", "all.ply.exr")
            self.assertGreater(error["covered"]["pixels"], 2000)
            self.assertEqual((error["all"]["maximum"], error["coverage_differs"]), (0, 0))
        self.assertEqual(self.done_json("info", "--json", "all.ply")[0]["objects"], 3)
        self.done("prepare", "all.ply", "-o", "again.ply")
        self.assertEqual(self.splats("again.ply")[1], self.splats("all.ply")[1])

    def test_objects_without_splats(self):
        """They have no epsilon, and take none away from the others, before and after a file."""
        away = [1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        self.write("scene.json", json.dumps(
            {"points": [{"file": "ball.ply", "transform": away}, "ball.ply"]}))
        box = ["--clip-box=-2,-2,-2,2,2,2"]
        view = ["--size", "96x96", "--camera", "camera.json", "--method"]
        self.done("prepare", "scene.json", "-o", "near.ply", *box)
        self.assertEqual(self.splats("near.ply")[1][0], "0 epsilon 0")
        self.done("render", "ball.ply", "-o", "ball.exr", *VIEW, "--write-camera", "camera.json")
        for method in ("reference", "two-pass", "deferred", "exact"):
            self.done("render", "scene.json", "-o", "near.exr", *view, method, *box)
            error = self.compare("near.exr", "ball.exr")
            self.assertGreater(error["covered"]["psnr"] or 999, 45, method)
            self.done("render", "near.ply", "-o", "again.exr", *view, method)
            self.assertEqual(self.compare("again.exr", "near.exr")["all"]["maximum"], 0)

    def test_refused(self):
        usage = [(["--fit", "0.1", "--fit-count", "9"], ["--fit-count"]),
                 (["--fit-color", "0.1"], ["--fit or --fit-count"]),
                 (["--fit-flat"], ["--fit or --fit-count"]),
                 (["--fit", "-1"], ["--fit", "-1"]),
                 (["--fit", "nan"], ["--fit", "nan"]),
                 (["--fit-count", "0"], ["--fit-count", "0"])]
        for options, words in usage:
            self.fails(2, words, "prepare", "ball.ply", "-o", "few.ply", *options)
        self.fails(1, ["splats cannot cover"], "prepare", "ball.ply", "-o", "few.ply",
                   "--fit-count", "1")
        self.fit("ball.ply", "few.ply", "--fit", "0.05")
        self.fails(1, ["fitted already"], "prepare", "few.ply", "-o", "more.ply", "--fit", "0.1")

    def test_damaged(self):
        self.fit("ball.ply", "few.ply", "--fit", "0.05")
        whole = self.read("few.ply")
        for old, new, words in [(b"object 0 epsilon ", b"object 0 epsilon -", "of object 0"),
                                (b"object 0 epsilon ", b"object 7 epsilon ", "of object 0"),
                                (b" field_3\n", b" field_4\n", "field_4"),
                                (b" tangent_x\n", b" other\n", "tangent_x")]:
            self.write("bad.ply", whole.replace(old, new, 1))
            self.fails(3, ["bad.ply", words], "info", "bad.ply")
        self.write("bad.ply", whole[:-9])
        self.fails(3, ["bad.ply", "cut short"], "render", "bad.ply", "-o", "out.exr", *VIEW)


command.main()
