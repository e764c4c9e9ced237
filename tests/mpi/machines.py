#!/usr/bin/env python3
"""Several processes under mpirun: the file that one process writes, byte for byte; frames split over
them; and a process that fails ends all with one line and no file harmed."""
import json
import os
import signal
import subprocess
import sys
import time

MPIRUN = sys.argv.pop(1)
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

# As root in a container, and with more processes than processors.
for name in ["ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe",
             "MCA_mpi_yield_when_idle"]:
    os.environ["OMPI_" + name] = "1"
os.environ["OMPI_MCA_btl_vader_single_copy_mechanism"] = "none"

SIZE = ["--size", "96x64", "--method", "two-pass", "--threads", "1"]
AOVS = ["--aov", "albedo,P,weight,fragments,coverage,id,layers"]


def ours(text):
    """What is not mpirun's own: its notices of a status that is not 0."""
    return [line for line in text.splitlines() if line.startswith("stipple: ")]


class Machines(command.CommandTest):
    def mpi(self, count, *arguments, **more):
        return subprocess.run([MPIRUN, "-n", str(count), command.TOOL, *arguments],
                              cwd=self.folder, capture_output=True, text=True, timeout=120, **more)

    def alike(self, *arguments, counts=(2, 3)):
        self.done("render", *arguments, "-o", "one.exr")
        for count in counts:
            run = self.mpi(count, "render", *arguments, "-o", "many.exr")
            self.assertEqual((run.returncode, run.stderr), (0, ""), (count, arguments))
            self.assertEqual(self.read("many.exr"), self.read("one.exr"), (count, arguments))

    def test_same_file(self):
        self.alike("ball.ply", *SIZE, counts=(1, 2, 4))
        self.alike("ball.ply", *SIZE, *AOVS, "--color-by", "height", "--samples", "4")
        self.alike("ball.ply", *SIZE, "--tile-memory", "300K", "--background", "1,0,0")

    def test_objects_and_no_normals(self):
        points = "".join("%r %r %r 9 8 7\n" % p for p in command.sphere(900))
        self.write("bare.xyz", points)
        self.write("scene.json", json.dumps({"points": [
            {"file": "ball.ply", "epsilon": 0.3}, {"file": "bare.xyz"}]}))
        self.alike("bare.xyz", *SIZE)
        self.alike("scene.json", *SIZE, *AOVS)

    def test_stats_and_camera(self):
        run = self.mpi(2, "render", "ball.ply", *SIZE, "-o", "out.exr", "--stats", "out.json",
                       "--write-camera", "camera.json", "--repeat", "2", "--preview", "out.png")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        stats = json.loads(self.read("out.json"))
        self.assertEqual(stats["splats"], 2000)
        self.assertIn("process 0 of 2, 1000 splats here", stats["plan"])
        names = [part["name"] for part in stats["passes"]]
        self.assertIn("exchange nearest", names)
        self.alike("ball.ply", *SIZE, "--camera", "camera.json")

    def path_of(self, count):
        self.done("render", "ball.ply", "--stats", "x.json", "--write-camera", "one.json", *SIZE)
        one = json.loads(self.read("one.json"))
        self.write("path.json", json.dumps([{**one, "near": 0.01 * (i + 1)} for i in range(count)]))

    def test_frames(self):
        """Five frames over three processes, by any method; and all processes at each frame."""
        self.path_of(5)
        shared = ["render", "ball.ply", "--camera", "path.json", "--frames", "0:4"]
        for more in [["--method", "exact", "--split", "frames"], ["--split", "points"]]:
            method = more[:2] if more[0] == "--method" else ["--method", "two-pass"]
            self.done(*shared, *method, "-o", "one.%d.exr")
            run = self.mpi(3, *shared, *more, "-o", "many.%d.exr")
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            for i in range(5):
                if more[0] == "--method":
                    self.assertEqual(self.read("many.%d.exr" % i), self.read("one.%d.exr" % i))
                else:
                    self.same_picture("many.%d.exr" % i, "one.%d.exr" % i)

    def same_picture(self, a, b):
        """The files differ by why the method was taken."""
        error = self.done_json("compare", a, b, "--json")
        self.assertEqual((error["all"]["maximum"], error["coverage_differs"]), (0, 0))

    def refused(self, status, words, count, *arguments):
        self.write("out.exr", b"the old file")
        before = self.listing()
        run = self.mpi(count, *arguments, "-o", "out.exr")
        self.assertEqual(run.returncode, status, run.stderr)
        self.assertEqual(len(ours(run.stderr)), 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertEqual(self.listing(), before)

    def test_refused(self):
        self.refused(3, ["missing.ply", "process 0"], 2, "render", "missing.ply", *SIZE)
        self.refused(2, ["two-pass"], 2, "render", "ball.ply", "--method", "exact")
        self.refused(2, ["--size"], 3, "render", "ball.ply", "--size", "x")
        self.refused(2, ["--frames"], 2, "render", "ball.ply", "--split", "frames")
        self.refused(1, ["cannot write"], 2, "render", "ball.ply",
                     *SIZE, "--stats", "no/x.json")
        self.write("few.ply", command.ply(command.sphere(3)))
        self.refused(1, ["every process needs one"], 4, "render", "few.ply", *SIZE)

    def test_one_fails(self):
        """Only process 1 has no device."""
        self.write("lame.sh", 'if [ "$OMPI_COMM_WORLD_RANK" = 1 ]; then\n'
                   '    export VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent\n'
                   'fi\nexec "$@"\n')
        self.write("out.exr", b"the old file")
        before = self.listing()
        run = subprocess.run([MPIRUN, "-n", "3", "sh", "lame.sh", command.TOOL, "render",
                              "ball.ply", *SIZE, "-o", "out.exr"], cwd=self.folder, timeout=120,
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertEqual(len(ours(run.stderr)), 1, run.stderr)
        self.assertIn("process 1: no Vulkan driver", run.stderr)
        self.assertEqual(self.listing(), before)

    def test_one_is_killed(self):
        self.write("out.exr", b"the old file")
        self.write("note.sh", 'echo $$ > pid.$OMPI_COMM_WORLD_RANK\nexec "$@"\n')
        process = subprocess.Popen(
            [MPIRUN, "-n", "2", "sh", "note.sh", command.TOOL, "render", "ball.ply", *SIZE,
             "--samples", "4096", "--size", "1024x1024", "-o", "out.exr"], cwd=self.folder,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        while not (os.path.exists(self.path("pid.1")) and self.read("pid.1").strip()):
            self.assertIsNone(process.poll(), "ended too soon")
            time.sleep(0.01)
        time.sleep(1)
        os.kill(int(self.read("pid.1")), signal.SIGKILL)
        process.communicate(timeout=60)
        self.assertNotEqual(process.returncode, 0)
        self.assertEqual(self.read("out.exr"), b"the old file")
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("out.")],
                         ["out.exr"])


command.main()
