#!/usr/bin/env python3
"""The command as shipped, with a Vulkan loader that fails the n-th call, or an allocator that fails
the n-th allocation: status 1, one line, no crash, no object left alive, no file harmed or left."""
import json
import os
import sys

LOADER, ALLOCATOR = os.path.abspath(sys.argv.pop(1)), os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import command

SIZE = ["--size", "24x16"]
OUTPUTS = ["-o", "out.exr", "--preview", "out.png", "--stats", "out.json"]
METHODS = [["--method", "exact"], ["--method", "two-pass"],
           ["--method", "deferred", "--path", "raster"]]
OLD = {name: b"the old file" for name in ["out.exr", "out.png", "out.json", "camera.json"]}


class Faults(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.write("ball.ply", command.ply(command.sphere(60)))
        for name, content in OLD.items():
            self.write(name, content)

    def report(self):
        """What the loader wrote: calls, the name that was made to fail, objects alive, misuse."""
        words = self.read("report.txt").decode().splitlines()[-1].split(None, 8)
        os.unlink(self.path("report.txt"))
        return int(words[1]), words[3], int(words[6]), words[8]

    def run_faulty(self, at, choice, *arguments):
        return self.run_tool(*arguments, env={
            "LD_LIBRARY_PATH": os.path.dirname(LOADER), "FAULT_AT": str(at), "FAULT_STICKY": "1",
            "FAULT_CHOICE": str(choice), "FAULT_REPORT": self.path("report.txt")})

    def one_line(self, run, what, allowed=(1,)):
        self.assertIn(run.returncode, allowed, (what, run.stderr))
        self.assertEqual(run.stderr.count("\n"), 1, (what, run.stderr))
        self.assertTrue(run.stderr.startswith("stipple: "), (what, run.stderr))

    def fail_call(self, at, *arguments):
        """Returns how many calls there were."""
        before = self.listing()
        run = self.run_faulty(at, at, *arguments)
        calls, failed, alive, misuse = self.report()
        self.assertEqual((alive, misuse), (0, "-"), (failed, arguments))
        if failed == "vkDeviceWaitIdle" or failed == "-":  # of the last there is nothing to say
            self.assertEqual((run.returncode, run.stderr), (0, ""))
        else:
            self.one_line(run, failed)
            self.assertEqual(self.listing(), before, failed)
        return calls

    def fail_some(self, count, *arguments):
        calls = self.fail_call(0, *arguments)
        for name, content in OLD.items():
            self.write(name, content)
        for i in range(count):
            self.fail_call(1 + i * (calls - 2) // (count - 1), *arguments)

    def test_render_calls(self):
        for method in METHODS:
            with self.subTest(method=method):
                self.fail_some(8, "render", "ball.ply", *OUTPUTS, *SIZE, *method, "--repeat", "1",
                               "--threads", "1")

    def test_second_frame(self):
        """The first frame stays; of the second, nothing appears."""
        self.done("render", "ball.ply", "--stats", "x.json", "--write-camera", "one.json", *SIZE,
                  "--method", "reference")
        one = self.read("one.json").decode()
        self.write("path.json", "[%s, %s]" % (one, one))
        arguments = ["render", "ball.ply", "-o", "f.%d.exr", "--camera", "path.json", "--frames",
                     "0:1", "--threads", "1"]
        self.assertEqual(self.run_faulty(0, 0, *arguments).returncode, 0)
        calls = self.report()[0]
        whole = self.read("f.0.exr")
        os.unlink(self.path("f.0.exr"))
        self.write("f.1.exr", b"the old file")
        self.one_line(self.run_faulty(calls - 8, 0, *arguments), "second frame")
        self.assertEqual(self.report()[2:], (0, "-"))
        self.assertEqual(self.read("f.0.exr"), whole)
        self.assertEqual(self.read("f.1.exr"), b"the old file")
        self.assertEqual(sorted(name for name in os.listdir(self.folder) if name.startswith("f.")),
                         ["f.0.exr", "f.1.exr"])

    def test_device_calls(self):
        self.fail_some(4, "devices")

    def test_report_calls(self):
        os.mkdir(self.path("report"))
        arguments = ["report", "ball.ply", "-o", "report", "--quick", *SIZE, "--threads", "1"]
        for at in [3, 40, 160, 300, 900]:
            run = self.run_faulty(at, at, *arguments)
            _, failed, alive, misuse = self.report()
            self.assertEqual((alive, misuse), (0, "-"), failed)
            self.one_line(run, failed)
            self.assertEqual(os.listdir(self.path("report")), [], failed)

    def old_or_whole(self, whole, what):
        """Every file is as it was, or as a run leaves it that nothing failed in; none is new."""
        for name, content in self.listing().items():
            if name == "out.json" and content != OLD[name]:
                self.assertEqual(list(json.loads(content)), list(json.loads(whole[name])), what)
            elif content != OLD.get(name):
                self.assertEqual(content, whole.get(name), (what, name))

    def fail_allocation(self, at, whole, arguments):
        for name, content in OLD.items():
            self.write(name, content)
        run = self.run_tool(*arguments, env={"LD_PRELOAD": ALLOCATOR, "ALLOCATION_AT": str(at)})
        what = (at, arguments)
        self.old_or_whole(whole, what)
        if run.returncode != 0:
            self.one_line(run, what, (1, 3))  # OpenEXR takes a lack of memory for a damaged file
        else:
            self.assertEqual(run.stderr, "", what)
            for name in OLD:
                self.assertEqual(self.read(name) == OLD[name], whole[name] == OLD[name], what)

    def fail_allocations(self, stride, *arguments):
        """The first forty and then every stride-th. Some are of no consequence (a buffer of
        stdio's), and then what is done is what is always done."""
        env = {"LD_PRELOAD": ALLOCATOR, "ALLOCATION_REPORT": self.path("count")}
        for name, content in OLD.items():
            self.write(name, content)
        self.done(*arguments, env=env)
        count = int(self.read("count"))
        os.unlink(self.path("count"))
        whole = self.listing()
        self.assertGreater(count, 30)
        for at in [*range(1, 40), *range(40, count + 1, stride)]:
            self.fail_allocation(at, whole, arguments)

    def test_allocations(self):
        reference = ["--method", "reference", "--threads", "1", *SIZE]
        self.fail_allocations(7, "render", "ball.ply", *OUTPUTS, "--write-camera", "camera.json",
                              "--aov", "albedo,id", *reference)
        self.done("render", "ball.ply", "-o", "a.exr", *reference)
        self.fail_allocations(11, "compare", "a.exr", "a.exr", "--json")
        self.fail_allocations(11, "plan", "ball.ply", "--threads", "1")
        self.fail_allocations(11, "info", "ball.ply", "--json", "--threads", "1")


command.main()
