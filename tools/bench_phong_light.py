#!/usr/bin/env python3
"""What light costs, with and without a light cube, as a Markdown table (docs/phong.md).

  tools/bench_phong_light.py FILE      one model, 1024 x 1024, exact, back faces culled, 1 to 8 lights

Milliseconds of a warm frame, record to fence: the median of the rounds, whose runs are interleaved.
"""
import json
import os
import statistics
import tempfile

from command_line import Arguments, existing, positive, stipple

DIRECTIONS = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, 1), (0, 1, 0.3), (0.2, 0.1, 1), (-1, 0, 0.5)]


def write_scene(path, model, lights):
    colors = [[0.2 + 0.05 * i, 0.3, 0.4 - 0.04 * i] for i in range(lights)]
    scene = {"points": [os.path.abspath(model)],
             "lights": [{"direction": d, "color": c} for d, c in zip(DIRECTIONS, colors)]}
    with open(path, "w") as out:
        json.dump(scene, out)


def frame_ms(folder, scene, cube, repeat):
    stats = os.path.join(folder, "stats.json")
    stipple("render", scene, "--size", "1024x1024", "--method", "exact", "--cull", "back", "--light-cube",
            cube, "--repeat", str(repeat), "--stats", stats, "-q", "-o", os.path.join(folder, "out.exr"))
    with open(stats) as text:
        return json.load(text)["frame_ms"]["median"]


def main():
    parser = Arguments(__doc__)
    parser.add_argument("file", type=existing)
    parser.add_argument("--rounds", type=positive, default=3)
    parser.add_argument("--repeat", type=positive, default=10)
    options = parser.parse_args()
    print("| lights | summed, ms | light cube, ms |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for lights in (1, 2, 4, 8):
            scene = os.path.join(folder, "scene.json")
            write_scene(scene, options.file, lights)
            times = {"off": [], "on": []}
            for _ in range(options.rounds):
                for cube in times:
                    times[cube].append(frame_ms(folder, scene, cube, options.repeat))
            print(f"| {lights} | {statistics.median(times['off']):.1f} | {statistics.median(times['on']):.1f} |")


if __name__ == "__main__":
    main()
