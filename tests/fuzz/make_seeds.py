#!/usr/bin/env python3
"""Writes the seeds: the small valid files that the corpus starts from, every branch of a format
that a fuzzer would take long to find. Beside them in the corpus stand cover_*, inputs by which
fuzzing reached more of a reader, and found_*, what once broke one. usage: make_seeds.py [FOLDER]; Python's own modules only."""
import gzip
import os
import struct
import sys
import zlib

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "corpus")
FOLDER = sys.argv[1] if len(sys.argv) > 1 else ROOT


def seed(target, name, content):
    os.makedirs(os.path.join(FOLDER, target), exist_ok=True)
    with open(os.path.join(FOLDER, target, name), "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())


# Bytes of a record of each point format.
LAS_SIZES = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67]


def record(data, kind=4, wide=False, user=b"LASF_Spec"):
    return (struct.pack("<H16sH", 0, user, kind) + struct.pack("<Q" if wide else "<H", len(data))
            + bytes(32) + data)


def extra(kind, name, options=0, missing=0, scale=1.0, offset=0.0):
    return (struct.pack("<2xBB32s4x", kind, options, name) + struct.pack("<Q16x", missing)
            + bytes(48) + struct.pack("<d16x", scale) + struct.pack("<d16x", offset) + bytes(32))


def las(form, minor, count=3, extras=b"", extra_bytes=0, evlr=False):
    size = {2: 227, 3: 235, 4: 375}[minor]
    vlrs = b"" if evlr or not extras else record(extras)
    length = LAS_SIZES[form] + extra_bytes
    head = bytearray(size)
    struct.pack_into("<4sHH16x BB", head, 0, b"LASF", 0, 0, 1, minor)
    struct.pack_into("<HIIBHI", head, 94, size, size + len(vlrs), 0 if evlr else bool(vlrs), form,
                     length, count)
    struct.pack_into("<6d", head, 131, 0.01, 0.01, 0.001, 5e5, 4e6, -10)
    points = b""
    for i in range(count):
        point = bytearray((i * 37 + 11 * j) & 0xff for j in range(length))
        struct.pack_into("<iiiHBB", point, 0, i * 100, -i, 7, 900 * i, 0x11, 2)
        points += point
    if minor == 4:
        at = size + len(vlrs) + len(points)
        struct.pack_into("<QIQ", head, 235, at if evlr else 0, bool(evlr), count)
    return bytes(head) + vlrs + points + (record(extras, wide=True) if evlr else b"")


def make_las():
    for form in range(11):
        seed("las", f"format_{form:02}.las", las(form, 2 if form < 4 else 3 if form < 6 else 4))
    kinds = b"".join(extra(k, b"k%d" % k, options=k % 2, missing=3) for k in range(1, 11))
    seed("las", "extras.las", las(7, 4, 3, kinds, 43))
    scaled = (extra(0, b"raw", options=2) + extra(3, b"Reflectance", 24, scale=0.01, offset=-5)
              + extra(13, b"pair") + extra(9, b"nx") + extra(9, b"ny") + extra(9, b"nz"))
    seed("las", "scaled.las", las(6, 4, 3, scaled, 20, evlr=True))
    seed("las", "none.las", las(3, 2, 0))


def lzf(data):
    """Literals, and one run where three bytes come again: every kind of part."""
    out, at = b"", 0
    while at < len(data):
        run = 0
        while at > 0 and at + run < len(data) and data[at + run] == data[at - 1] and run < 264:
            run += 1
        if run >= 3:
            long = run - 2 >= 7
            out += bytes([(7 if long else run - 2) << 5]) + (bytes([run - 9]) if long else b"")
            out += b"\0"
            at += run
        else:
            part = data[at:at + 5]
            out += bytes([len(part) - 1]) + part
            at += len(part)
    return out


def pcd_head(fields, sizes, types, counts, width, height, data, extra_lines=""):
    return ("# .PCD v.7 - Point Cloud Data file format\nVERSION .7\n"
            f"FIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\n{extra_lines}"
            f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n"
            f"POINTS {width * height}\nDATA {data}\n").encode()


def make_pcd():
    xyz = ("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 2, 2)
    seed("pcd", "ascii.pcd", pcd_head(*xyz, "ascii")
         + b"1 2 3 4278190335\nnan nan nan nan\n4 5 6 2.3e-38\n7 8 9 -1.7e38\n")
    points = [struct.pack("<fffI", i, -i, 1 + i, 0xff112233 * (i + 1) & 0xffffffff)
              for i in range(4)]
    seed("pcd", "binary.pcd", pcd_head(*xyz, "binary") + b"".join(points))
    soa = b"".join(p[4 * f:4 * f + 4] for f in range(4) for p in points)
    packed = lzf(soa)
    seed("pcd", "compressed.pcd", pcd_head(*xyz, "binary_compressed")
         + struct.pack("<II", len(packed), len(soa)) + packed)
    flat = bytes(4 * 4 * 300)
    packed = lzf(flat)
    seed("pcd", "zeros.pcd", pcd_head("x y z rgba", "4 4 4 4", "F F F U", "1 1 1 1", 300, 1,
                                      "binary_compressed")
         + struct.pack("<II", len(packed), len(flat)) + packed)
    many = ("x y z _ normal_x normal_y normal_z curvature intensity label hist", "8 8 8 1 4 4 4 4 4 "
            "2 1", "F F F U F F F F F U I", "1 1 1 4 1 1 1 1 1 1 3", 2, 1)
    seed("pcd", "many.pcd", pcd_head(*many, "binary") + bytes(range(106)))
    seed("pcd", "many_ascii.pcd", pcd_head(*many, "ascii")
         + b"1 2 3 0 0 0 0 0 0 1 .5 9 4 1 2 3\n" * 2)
    seed("pcd", "old.pcd", b"COLUMNS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\n"
         b"DATA ascii\n1 2 3\n")
    dense = struct.pack("<fff", 1, 2, 3)
    seed("pcd", "padded.pcd", pcd_head("x y z _", "4 4 4 1", "F F F U", "1 1 1 4", 1, 1,
                                       "binary_compressed")
         + struct.pack("<II", 13, 12) + b"\x0b" + dense)


def make_ply():
    head = ("ply\nformat {} 1.0\ncomment c\nelement pre 1\nproperty list uchar short l\n"
            "element vertex 2\nproperty float x\nproperty double y\nproperty short z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
            "property float intensity\n{}end_header\n")
    seed("ply", "ascii.ply", head.format("ascii", "") + "2 1 1\n1 2 3 4 5 6 7 8\n"
         "-1e5 .5 nan 0 255 3 8 1\n")
    for order, form in [("<", "binary_little_endian"), (">", "binary_big_endian")]:
        for many in (False, True):
            body = struct.pack(order + "Bhh", 2, 1, 2)
            for i in range(2):
                body += struct.pack(order + "fdhBBBBf", 1.5, -2.25, i, 9, 8, 7, 255, 3)
                body += struct.pack(order + "iBB", 2, 7, 7) if many else b""
            more = "property list int uchar m\n" if many else ""
            seed("ply", f"{form}_{'list' if many else 'flat'}.ply",
                 head.format(form, more).encode() + body)
    seed("ply", "normals.ply", "ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty float x\r\n"
         "property float y\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n"
         "property float psz\r\nproperty uint label\r\nelement face 1\r\n"
         "property list uchar int vertex_indices\r\nend_header\r\n1 2 0 0 1 .5 3\r\n3 0 0 0\r\n")
    seed("ply", "prepared.ply", b"ply\nformat binary_little_endian 1.0\ncomment stipple prepared 1\n"
         b"element vertex 1\n" + b"".join(b"property %s\n" % p for p in (
             b"double x", b"double y", b"double z", b"float nx", b"float ny", b"float nz",
             b"float radius", b"float red", b"float green", b"float blue", b"float opacity",
             b"uint input_index", b"ushort object", b"uchar group")) + b"end_header\n"
         + struct.pack("<3d8fIHB", 1, 2, 3, 0, 0, 1, .5, .1, .2, .3, .9, 0, 0, 1))
    fields = [b"nx", b"ny", b"nz", b"tangent_x", b"tangent_y", b"tangent_z", b"radius_u",
              b"radius_v", *(b"field_%d" % i for i in range(4))]
    clips = [b"clip_%d_%s" % (line, axis) for line in range(2) for axis in (b"a", b"b", b"c")]
    for name, lines in [("ellipses", 0), ("clipped", 2)]:
        seed("ply", name + ".ply", b"ply\nformat binary_little_endian 1.0\n"
             b"comment stipple prepared 1\ncomment stipple object 0 epsilon 0.125\n"
             b"element vertex 2\n" + b"".join(b"property double %s\n" % p for p in (b"x", b"y", b"z"))
             + b"".join(b"property float %s\n" % p for p in fields + (clips if lines else []))
             + (b"property uchar clip_count\nproperty uchar clip_reflex\n" if lines else b"")
             + b"end_header\n" + b"".join(
                 struct.pack("<3d12f", i, 2, 3, 0, 0, 1, 1, 0, 0, .5, .25, 0, .1, .2, -.1)
                 + (struct.pack("<6fBB", 1, 0, .5, 0, -1, .25, lines, i) if lines else b"")
                 for i in range(2)))
    seed("ply", "objects.ply", "ply\nformat ascii 1.0\ncomment stipple prepared 1\n"
         "comment stipple object 0 epsilon 0.25\n"
         "comment stipple object 1 epsilon 1e-3 normals estimated\n"
         "element vertex 2\nproperty double x\nproperty double y\nproperty double z\n"
         "property ushort object\nend_header\n1 2 3 1\n4 5 6 0\n")


def make_text():
    for name, text in {
            "plain": "1 2 3\n4 5 6\n", "normals": "1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n",
            "colours": "1,2,3,255,0,9\n4,5,6,1,2,3\n", "mac": "1 2 3\r4 5 6\r",
            "names": "x y z intensity r g b\n1 2 3 .5 1 2 3\n4 5 6 .25 4 5 6\n",
            "pts": "2\n1 2 3 -1000 255 0 9\n4 5 6 7 1 2 3\n",
            "cloudcompare": "//X,Y,Z,R,G,B,Label\n1,2,3,255,0,9,1\n4,5,6,1,2,3,2\n",
            "odd": "# c\n\n 1e3;-2.;.5d1 \n1.#QNAN inf -nan\n+1 2 3 # c\n"}.items():
        seed("text", name + ".xyz", text)
    for name, text in {
            "plain": "OFF\n2 1 0\n1 2 3\n4 5 6\n3 0 1 0\n", "line": "OFF 1 0 0 # c\n1 2 3\n",
            "all": "STNCOFF\n1 0 0\n1 2 3 0 0 1 255 0 9 255 .5 .5\n",
            "colour": "COFF\n2 0 0\n1 2 3 .1 .2 .3 1\n4 5 6 .4 .5 .6 1\n"}.items():
        seed("off", name + ".off", text)
    for name, text in {
            "faces": "# c\nv 1 2 3\nv 4 5 6 1\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//2 -1//-1\n",
            "colours": "v 1 2 3 .5 .5 .5\nv 4 5 6 1 1 1\nvt 0 0\nvn 0 0 1\nvn 1 0 0\n",
            "textured": "o a\nv 1 2 3 1 255 0 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 1/1/1 1/1/1\n"
                        "f 1/1 1/1 1/1\nf 1 1 1\nl 1 1\n"}.items():
        seed("obj", name + ".obj", text)


MATRIX = "[[1,0,0,0],[0,1,0,0],[0,0,1,-5],[0,0,0,1]]"


def make_json():
    lens = {"fov": '"fov_y_deg":30', "ortho": '"ortho_height":2.5,"near":-1,"far":4',
            "intrinsics": '"intrinsics":{"fx":500,"fy":510,"cx":320.5,"cy":240},"width":640,'
                          '"height":480,"orthographic":false,"convention":"opencv"'}
    for name, text in lens.items():
        seed("camera_json", name + ".json", '{"world_to_camera":%s,%s}' % (MATRIX, text))
    seed("camera_json", "path.json", "[%s]" % ",".join(
        '{"world_to_camera":%s,%s,"near":0.1,"far":null}' % (MATRIX, lens["fov"]) for _ in "ab"))
    seed("scene_json", "full.json", '{"up":"-y","points":["a.ply",{"file":"/b.ply","transform":'
         '[[0,-2,0,1],[2,0,0,2],[0,0,2,3],[0,0,0,1]],"material":{"ambient":0.05,"diffuse":0.6,'
         '"specular":0.5,"shininess":96,"albedo":[1,0.5,0]},"epsilon":0.1,"opacity":0.5,"color_by":'
         '"height","transfer":"srgb","name":"n"}],"lights":[{"direction":[1,2,2],"color":[1,1,1]},'
         '{"position":[1,2,3]},{"at_eye":true}],"camera":{"world_to_camera":%s,"fov_y_deg":30},'
         '"comment":"c"}' % MATRIX)
    seed("scene_json", "least.json", ' {"points":[]}')
    seed("scene_json", "range.json", '{"range":{"frames":[{"depth":"d.png","color":"c.png","pose":'
         '[1,2,3,0,0,0,1],"intrinsics":{"fx":9,"fy":9,"cx":4,"cy":3},"margin":2,"disparity":'
         '{"baseline":0.1,"offset":3},"sensor":{"type":"stereo","sigma_disparity":0.2}}],'
         '"depth_scale":1000,"uncertainty":2,"splats":"discs"}}')
    seed("scene_json", "range_poses.json", '{"range":{"intrinsics":{"fx":9,"fy":9,"cx":4,"cy":3},'
         '"frames":[{"camera_to_world":%s,"depth":"d.pgm","color":"c.ppm"}],"sensor":{"type":'
         '"constant","sigma":0.1}}}' % MATRIX)
    seed("scene_json", "range_folder.json", '{"range":"folder"}')
    seed("scene_json", "camera_file.json", '{"points":["a.ply"],"camera_file":"c.json"}')


# EXR: scan lines, and tiles, of float, half and uint.
def attribute(name, kind, value):
    return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value


def exr_head(kinds, compression, tiles):
    channels = b"".join(n + b"\0" + struct.pack("<iB3xii", k, 0, 1, 1) for n, k in kinds) + b"\0"
    box = struct.pack("<4i", 0, 0, 3, 3)
    return (struct.pack("<II", 20000630, 2 | (0x200 if tiles else 0))
            + attribute(b"channels", b"chlist", channels)
            + attribute(b"compression", b"compression", bytes([compression]))
            + attribute(b"dataWindow", b"box2i", box) + attribute(b"displayWindow", b"box2i", box)
            + attribute(b"lineOrder", b"lineOrder", b"\0")
            + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
            + attribute(b"screenWindowCenter", b"v2f", bytes(8))
            + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
            + (attribute(b"tiles", b"tiledesc", struct.pack("<IIB", 2, 2, 0)) if tiles else b"")
            + b"\0")


def zip_pack(data):
    split = data[::2] + data[1::2]
    delta = bytes([split[0]] + [(split[i] - split[i - 1] + 128) & 0xff
                                for i in range(1, len(split))])
    return zlib.compress(delta)


def make_exr():
    kinds = [(b"A", 1), (b"B", 1), (b"G", 1), (b"R", 1), (b"Z", 2), (b"id", 0)]
    line = bytes(range(4 * 2)) * 4 + struct.pack("<4f", 1, 2, 3, 4) + struct.pack("<4I", 1, 2, 3, 4)
    for name, compression, tiles in [("plain", 0, False), ("zips", 2, False), ("zip", 3, False),
                                     ("tiles", 0, True)]:
        head = exr_head(kinds, compression, tiles)
        if tiles:
            data = line[:len(line) // 2] * 2
            chunks = [struct.pack("<4iI", x, y, 0, 0, len(data)) + data
                      for y in range(2) for x in range(2)]
        elif compression == 3:
            packed = zip_pack(line * 4)
            chunks = [struct.pack("<iI", 0, len(packed)) + packed]
        else:
            packed = zip_pack(line) if compression else line
            packed = packed if len(packed) < len(line) else line
            chunks = [struct.pack("<iI", y, len(packed)) + packed for y in range(4)]
        at, table = len(head) + 8 * len(chunks), b""
        for chunk in chunks:
            table += struct.pack("<Q", at)
            at += len(chunk)
        seed("exr", name + ".exr", head + table + b"".join(chunks))


def make_environment():
    head = b"#?RADIANCE\n%sFORMAT=32-bit_rle_rgbe\n\n%s\n"
    pixel, run = bytes([9, 80, 200, 130]), bytes([1, 1, 1, 5])
    new = b"\2\2\0\12" + (b"\3\1\2\3" + bytes([128 + 7, 64])) * 4
    for name, lines, size, data in [
            ("flat", b"", b"-Y 2 +X 4", pixel * 8), ("new", b"", b"-Y 2 +X 10", new * 2),
            ("old", b"EXPOSURE=2\n", b"+Y 2 -X 6", (pixel + run) * 2),
            ("long", b"GAMMA=2.2\n", b"-Y 1 +X 262", pixel + run + run[:3] + b"\1"),
            ("columns", b"# a remark\n", b"+X 3 -Y 2", pixel * 6)]:
        seed("environment", name + ".hdr", head % (lines, size) + data)
    for name, kinds in [("color", [(b"B", 1), (b"G", 1), (b"R", 1)]), ("grey", [(b"Y", 1)])]:
        line = bytes(range(8)) * len(kinds)
        start = exr_head(kinds, 0, False)
        table = b"".join(struct.pack("<Q", len(start) + 32 + i * (8 + len(line))) for i in range(4))
        chunks = b"".join(struct.pack("<iI", i, len(line)) + line for i in range(4))
        seed("environment", name + ".exr", start + table + chunks)


def make_gzip():
    one = gzip.compress(b"1 2 3\n" * 20, mtime=0)
    seed("gzip", "one.gz", one)
    seed("gzip", "two.gz", one + gzip.compress(bytes(5000), mtime=0))
    seed("gzip", "named.gz", one[:3] + b"\x08" + one[4:10] + b"name\0" + one[10:])
    seed("gzip", "stored.gz", gzip.compress(bytes(range(256)), 0, mtime=0))
    seed("gzip", "trailing.gz", one + b"more bytes that are no member")
    seed("gzip", "plain", b"no gzip at all, and long enough")


def nifti(order, code, voxels, dims, srow=None, quaternion=None):
    head = bytearray(352)
    struct.pack_into(order + "i", head, 0, 348)
    struct.pack_into(order + "8h", head, 40, 3, *dims, 1, 1, 1, 1)
    struct.pack_into(order + "h", head, 70, code)
    struct.pack_into(order + "8f", head, 76, -1, 1, 2, 3, 0, 0, 0, 0)
    struct.pack_into(order + "3f", head, 108, 352, 2, -1)
    if quaternion:
        struct.pack_into(order + "h", head, 252, 1)
        struct.pack_into(order + "6f", head, 256, *quaternion, 5, 6, 7)
    if srow:
        struct.pack_into(order + "h", head, 254, 1)
        struct.pack_into(order + "12f", head, 280, *srow)
    head[344:348] = b"n+1\0"
    return bytes(head) + voxels


def make_volume():
    bytes8, floats = bytes(range(24)), struct.pack("<24f", *range(24))
    dims = (2, 3, 4)
    seed("volume", "plain.nii", nifti("<", 2, bytes8, dims))
    seed("volume", "turned.nii", nifti("<", 16, floats, dims, (0, 2, 0, 1, 0, 0, -3, 2, 1, 0, 0, 3)))
    seed("volume", "quaternion.nii", nifti(">", 256, bytes8, dims, None, (0.5, 0.5, 0.5)))
    nrrd = "NRRD0005\n# seed\ntype: {}\ndimension: 3\nsizes: 2 3 4\nspace: left-posterior-superior\n" \
           "space directions: (1,0,0) (0,0,2) (0,-3,0)\nspace origin: (1,2,3)\n" \
           "encoding: {}\nendian: little\n{}\n"
    seed("volume", "raw.nrrd", nrrd.format("float", "raw", "byte skip: -1\n").encode() + floats)
    seed("volume", "packed.nrrd", nrrd.format("uint8", "gzip", "").encode()
         + gzip.compress(bytes8, mtime=0))
    seed("volume", "detached.nrrd", nrrd.format("uint8", "raw", "data file: none.raw\n"))
    meta = "ObjectType = Image\nNDims = 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n" \
           "CompressedData = {}\nDimSize = 2 3 4\nElementSpacing = 1 1 2\nElementType = MET_UCHAR\n" \
           "HeaderSize = {}\nElementDataFile = {}\n"
    seed("volume", "local.mha", meta.format("False", 0, "LOCAL").encode() + bytes8)
    seed("volume", "packed.mha", meta.format("True", 0, "LOCAL").encode() + zlib.compress(bytes8))
    seed("volume", "last.mha", meta.format("False", -1, "LOCAL").encode() + b"pad" + bytes8)
    inr = b"#INRIMAGE-4#{\nXDIM=2\nYDIM=3\nZDIM=4\nVDIM=1\nTYPE=float\nPIXSIZE=32 bits\n" \
          b"CPU=decm\nVX=1\nVY=1\nVZ=2.5\n"
    seed("volume", "float.inr", inr + b"\n" * (252 - len(inr)) + b"##}\n" + floats)
    seed("volume", "raw", bytes(range(64)))


def png(width, height, depth, kind, rows):
    def chunk(name, data):
        return (struct.pack(">I", len(data)) + name + data
                + struct.pack(">I", zlib.crc32(name + data)))
    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
            + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows)))
            + chunk(b"IEND", b""))


def make_range():
    seed("range", "depth.pgm", b"dP5 # remark\n2 2\n65535\n" + bytes(range(8)))
    seed("range", "depth8.pgm", b"dP5 2 2 200 " + bytes(range(4)))
    seed("range", "color.ppm", b"cP6\n2 1\n255\n" + bytes(range(6)))
    seed("range", "depth16.png", b"d" + png(2, 2, 16, 0, [bytes(4), bytes(range(4))]))
    seed("range", "color.png", b"c" + png(2, 1, 8, 2, [bytes(range(6))]))
    seed("range", "alpha.png", b"c" + png(2, 1, 8, 6, [bytes(range(8))]))
    seed("range", "bits.png", b"d" + png(3, 1, 2, 0, [b"\x1b"]))
    for name, kinds in [("color", [(b"B", 1), (b"G", 1), (b"R", 1)]), ("depth", [(b"Z", 2)])]:
        line = bytes(range(4 * (2 if len(kinds) == 3 else 4))) * len(kinds)
        start = exr_head(kinds, 0, False)
        table = b"".join(struct.pack("<Q", len(start) + 32 + i * (8 + len(line))) for i in range(4))
        chunks = b"".join(struct.pack("<iI", i, len(line)) + line for i in range(4))
        seed("range", name + ".exr", name[:1].encode() + start + table + chunks)
    pgm = b"P5 2 1 65535 " + bytes((0, 9, 1, 0))
    for options in (0x00, 0x39, 0x72):
        seed("range", "frame_%02x" % options, b"f" + struct.pack("<BH", options, len(pgm)) + pgm
             + b"P6 2 1 200 " + bytes(range(6)))
    deep = png(2, 1, 16, 0, [bytes(range(4))])
    seed("range", "frame_png", b"f" + struct.pack("<BH", 8, len(deep)) + deep
         + png(2, 1, 8, 2, [bytes(range(6))]))
    seed("range", "intrinsics.txt", "ifx 518\nfy 519 # so\ncx 1.5\ncy 2.5\n\ndepth_scale 1e3\n")
    seed("range", "poses.txt", "p# remark\n1 2 3 0 0 0 1\r\n-1 .5 2e3 0 0.6 0 0.8\n")


def make_transfer_json():
    seed("transfer_json", "values.json", '{"name": "n", "unit": "value", "points": ['
         '{"value": -1, "opacity": 0, "color": "#80ff00"}, {"value": 2, "opacity": 1, '
         '"color": [1, 0.5, 2]}, {"value": 2, "opacity": 0.5}], "comment": "c"}')
    seed("transfer_json", "range.json", '{"unit": "range", "points": [{"value": 0, "opacity": 1}]}')


for make in (make_las, make_pcd, make_ply, make_text, make_json, make_exr, make_environment,
             make_gzip, make_volume, make_range, make_transfer_json):
    make()
