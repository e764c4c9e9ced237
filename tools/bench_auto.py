#!/usr/bin/env python3
"""What auto takes, and what features cost, as Markdown tables.

  tools/bench_auto.py auto FILE...      what --max-error takes for bounds from 1e-2 to 1e-5, beside
                                        the fastest of `stipple report --quick` within each bound:
                                        all in one process a model, interleaved (docs/results/auto.md)
  tools/bench_auto.py bounds FILE...    what --max-error takes, the error that it says at most, and that of
                                        the picture that it gives: no times, so that any machine will do;
                                        of folders every file that holds points
  tools/bench_auto.py features FILE     resources, passes, constants, bytes and least milliseconds of each
                                        feature off and on (docs/results/features.md); --rounds 0:
                                        all but the milliseconds
  tools/bench_auto.py prices FILE...    prices in nanoseconds of every kind of plan, fitted to the
                                        calibration's scenes and the sweeps of these models
                                        together (the built-in ones: src/plan/profile.c); --only
                                        WORD: of kinds that begin so; --lean L: towards the
                                        proportions that they have there (0: not at all); --write:
                                        they take their place
  tools/bench_auto.py reports DIR FILE...
                                        the whole `stipple report` of every model, into DIR/report-MODEL

auto and bounds take --opacity A: both faces of a transparent scene.

auto and reports: 1024 x 1024, back faces culled, no screen-space floor, the automatic view; bounds: 800 x 600.
Prices are those that the device was calibrated with (stipple devices --calibrate), last or now.
"""
import csv
import json
import os
import re
import sys
import tempfile

from command_line import Arguments, Failed, ROOT, STIPPLE, run, stipple

VIEW = ["--size", "1024x1024", "--cull", "back", "--min-splat", "0", "-q"]


def way(pick, prefix=""):
    words = [pick[prefix + "method"], pick[prefix + "path"]]
    if pick[prefix + "overlap"]:
        words.append("c " + pick[prefix + "overlap"])
    if pick[prefix + "voronoi"]:
        words.append(pick[prefix + "voronoi"])
    if pick[prefix + "payload"]:
        words.append(pick[prefix + "payload"])
    if pick[prefix + "transparency"] not in ("", words[0]):
        words.append(pick[prefix + "transparency"])
    if pick[prefix + "peel_layers"]:
        words.append(pick[prefix + "peel_layers"] + " layers")
    return " ".join(words)


def verdict(pick):
    """Within 15 % of the fastest; within that or the spread of the two times."""
    if pick["best_ms"] == "":
        return "-", True, True
    ms, best = float(pick["ms"]), float(pick["best_ms"])
    spread = float(pick["ms_quartile1"]) <= float(pick["best_ms_quartile3"])
    near = ms <= 1.15 * best
    return f"{ms / best:.2f}" + ("" if near or spread else " **slower**"), near, near or spread


def auto(models, rounds, more, keep):
    print("| model | bound | taken | ms, predicted | ms | error, at most | error | fastest within the "
          "bound | ms | ratio |\n|---|---:|---|---:|---:|---:|---:|---|---:|---:|")
    total = near = spread = kept = said = 0
    for model in models:
        with tempfile.TemporaryDirectory() as temporary:
            name = re.sub(r"\.\w+$", "", os.path.basename(model))
            folder = os.path.join(keep, "report-" + name) if keep else temporary
            os.makedirs(folder, exist_ok=True)
            stipple("report", model, "-o", folder, "--quick", "--rounds", str(rounds), *VIEW, *more)
            with open(os.path.join(folder, "auto.csv"), newline="", encoding="ascii") as file:
                picks = list(csv.DictReader(file))
        for pick in picks:
            ratio, close, good = verdict(pick)
            total, near, spread = total + 1, near + close, spread + good
            inside = float(pick["error"]) <= float(pick["bound"])
            kept += inside
            said += float(pick["error"]) <= float(pick["predicted_error"])
            best = way(pick, "best_") if pick["best_ms"] else "none"
            print(f"| {os.path.basename(model)} | {float(pick['bound']):g} | {way(pick)} | "
                  f"{float(pick['predicted_ms']):.1f} | {float(pick['ms']):.1f} | "
                  f"{float(pick['predicted_error']):.2g} | {float(pick['error']):.2g}"
                  f"{'' if inside else ' **beyond**'} | "
                  f"{'the same' if best == way(pick) else best} | "
                  f"{float(pick['best_ms'] or 'nan'):.1f} | {ratio} |", flush=True)
    print(f"\n{kept} of {total} choices are within their bound, {said} within what was said at most; {near} "
          f"are within 15 % of the fastest, {spread} within that or the quartiles of the two times.")


BOUNDS = ["1e-2", "3e-3", "1e-3", "1e-4", "1e-5"]
SMALL = ["--size", "800x600", "-q"]


def taken(text):
    """From the plan's text: what was taken, and the error that was predicted."""
    why = re.search(r"^why: (.*)$", text, re.M).group(1)
    overlap = re.search(r"(\d+) groups? at overlap ([0-9.]+)", why)
    words = list(re.search(r"^method (\S+), path (\S+),", text, re.M).groups())
    layers = re.search(r"peel is .*: the (\d+) nearest layers", why)
    most = re.search(r"error at most ([-0-9.e]+)\)", why)
    packed = " packed" if re.search(r" packed=1", text) else ""
    groups = f" c {overlap[2]}, K = {overlap[1]}" if overlap else f" peel {layers[1]}" if layers else ""
    return " ".join(words) + packed + groups, most[1] if most else "-"


def points_in(names):
    """Files, and all files in folders."""
    for name in names:
        if os.path.isdir(name):
            yield from sorted(entry.path for entry in os.scandir(name) if entry.is_file())
        else:
            yield name


def judged(model, bound, folder, more):
    """What was taken within the bound, the error that it said at most, and the one that came."""
    truth, out, stats = (os.path.join(folder, n) for n in ["t.exr", "o.exr", "s.json"])
    stipple("render", model, "-o", out, "--max-error", bound, "--stats", stats, *SMALL, *more)
    with open(stats, encoding="utf-8") as file:
        what, most = taken(json.load(file)["plan"])
    return what, most, json.loads(stipple("compare", "--json", out, truth))["covered"]["mean_absolute"]


class Tally:
    def __init__(self):
        self.total = self.kept = self.said = self.files = 0
        self.refused = []

    def cell(self, bound, what, most, error):
        self.total += 1
        inside, honest = error <= float(bound), most == "-" or error <= 1.05 * float(most)
        self.kept += inside
        self.said += honest
        return (f"{what}: {most}, {error:.2g}" + ("" if inside else " **beyond**") +
                ("" if honest else " **more than said**"))


def bounds(models, more):
    print("| model | " + " | ".join(BOUNDS) + " |\n|---|" + "---|" * len(BOUNDS))
    tally = Tally()
    for model in points_in(models):
        with tempfile.TemporaryDirectory() as folder:
            try:
                stipple("render", model, "-o", os.path.join(folder, "t.exr"), "--method", "reference",
                        *SMALL, *more)
            except Failed as error:
                tally.refused.append((model, (error.said or [str(error)])[-1]))
                continue
            cells, before = [], None
            for bound in BOUNDS:
                now = judged(model, bound, folder, more)
                cells.append("the same" if now[:2] == before else tally.cell(bound, *now))
                before = now[:2]
            tally.files += 1
            print(f"| {os.path.basename(model)} | " + " | ".join(cells) + " |", flush=True)
    print(f"\n{tally.files} files. Of {tally.total} different pictures {tally.kept} are within their bound, "
          f"and {tally.said} within what was said at most.")
    for model, line in tally.refused:
        print(f"Not rendered: {os.path.basename(model)}: {line}", file=sys.stderr)


PLAIN = ["--two-sided", "off", "--min-splat", "0", "--size", "512x512", "-q"]
FEATURES = [
    ("two-sided", ["--two-sided", "on"]),
    ("screen-space floor", ["--min-splat", "1.5"]), ("culling", ["--cull", "back"]),
    ("Gauss kernel", ["--kernel", "gauss"]), ("orthographic", ["--ortho"]),
    ("local viewer", ["--local-viewer"]), ("background", ["--background", "0.2,0.2,0.2"]),
    ("AOV albedo", ["--aov", "albedo"]), ("AOV P", ["--aov", "P"]),
    ("AOV weight", ["--aov", "weight"]), ("AOV fragments", ["--aov", "fragments"]),
    ("AOV coverage", ["--aov", "coverage"]), ("AOV id", ["--aov", "id"]),
    ("AOV layers", ["--aov", "layers"]), ("4 samples", ["--samples", "4"]),
]


def drawn(model, options, folder, frames):
    """Constants, resources with their bytes, passes: of the plan's text; the least milliseconds."""
    path = os.path.join(folder, "s.json")
    stipple("render", model, *options, "--repeat", str(frames), "--stats", path)
    with open(path, encoding="utf-8") as file:
        stats = json.load(file)
    text = stats["plan"]
    constants = dict(re.findall(r" (\w+)=(\d+)", re.search(r"^constants:.*$", text, re.M).group(0)))
    resources = {(m[1] + " " + m[2]): int(m[3]) for m in
                 re.finditer(r"^  (\S.*?) +(scene|transient|output) .* (\d+) bytes$", text, re.M)}
    passes = re.findall(r"^  (?:fill|reset|dispatch\*?|draw) +(.+?)(?: reads |; writes |$)", text, re.M)
    return constants, resources, [name.strip() for name in passes], stats["frame_ms"]["min"]


def difference(off, on):
    words = [f"{name} {off[0].get(name, 0)} to {on[0].get(name, 0)}"
             for name in sorted({*off[0], *on[0]}) if off[0].get(name) != on[0].get(name)]
    added = [name for name in on[1] if name not in off[1]]
    gone = [name for name in off[1] if name not in on[1]]
    passes = [name for name in on[2] if name not in off[2]]
    return ", ".join(words) or "-", ", ".join(["+" + n for n in added] + ["-" + n for n in gone] +
                                              ["+" + n + " (pass)" for n in passes]) or "-"


def features(model, method, rounds):
    """Frames of one process are alike, those of two differ by up to 1.5 with the memory that they
    got: so all ways have their turn in every round, and the least of all rounds counts."""
    base = [*PLAIN, "--method", method]
    ways = [base] + [base + more for _, more in FEATURES]
    with tempfile.TemporaryDirectory() as folder:
        turns = [[drawn(model, way, folder, 5 if rounds else 1) for way in ways]
                 for _ in range(max(rounds, 1))]
    off, least = turns[0][0], [min(turn[k][3] for turn in turns) for k in range(len(ways))]
    without = sorted(turn[0][3] for turn in turns)
    times = f", {' and '.join(f'{ms:.1f}' for ms in without)} ms" if rounds else ""
    print(f"Method {method}, nothing on: {len(off[1])} resources of {sum(off[1].values())} bytes, "
          f"{len(off[2])} passes{times}.\n\n"
          "| feature | constants | resources and passes | bytes more | ms | of the time without |\n"
          "|---|---|---|---:|---:|---:|")
    for k, (name, _) in enumerate(FEATURES, 1):
        on = turns[0][k]
        constants, what = difference(off, on)
        ms = f"{least[k]:.1f} | {least[k] / least[0]:.2f}" if rounds else "- | -"
        print(f"| {name} | {constants} | {what} | {sum(on[1].values()) - sum(off[1].values())} | {ms} |")


def costs(*arguments):
    """Of a run's log: kind, milliseconds, amounts."""
    log = run(STIPPLE, *arguments, "--verbose").stderr
    for line in re.finditer(r"cost of ([^:]+): ([-0-9.e+]+) ms(.*)$", log, re.M):
        terms = re.findall(r"; ([a-z ]+) ([-0-9.e+]+)", line[3])
        yield line[1], float(line[2]), {name: float(value) for name, value in terms}


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def least_squares(rows, known, lean):
    """Prices >= 0 of least (predicted - measured)^2 / measured, leaning on known ones: as src/plan/fit.c."""
    terms = sorted({term for _, amount in rows for term in amount})
    root = [(1e6 * ms) ** 0.5 for ms, _ in rows]
    columns = [[amount.get(term, 0) / r for r, (_, amount) in zip(root, rows)] for term in terms]
    scale = [dot(column, column) ** -0.5 for column in columns]
    columns = [[v * s for v in column] for column, s in zip(columns, scale)]
    old = [known.get(term, 0) / s for term, s in zip(terms, scale)]
    predicted = [dot(old, row) for row in zip(*columns)]
    level = dot(predicted, root) / dot(predicted, predicted) if any(predicted) else 0
    price, left = [0.0] * len(terms), list(root)
    for _ in range(4000):
        for t, column in enumerate(columns):
            pull = dot(column, left) + lean * (level * old[t] - price[t])
            step = max(-price[t], pull / (1 + lean))
            price[t] += step
            left = [r - step * v for v, r in zip(column, left)]
    spread = (sum((r / whole) ** 2 for r, whole in zip(left, root)) / len(left)) ** 0.5
    found = {term: level * known[term] for term in known if term not in terms}
    return found | {term: p * s for term, p, s in zip(terms, price, scale) if p > 0}, spread


WORDS = {"two-pass compute": "TWO_PASS", "two-pass compute color": "TWO_PASS_COLOR",
         "peel compute": "PEEL", "peel compute color": "PEEL_COLOR"}
PROFILE = os.path.join(ROOT, "src", "plan", "profile.c")


def enum_name(kind):
    return "PLAN_COST_" + WORDS.get(kind, kind.upper().replace(" ", "_").replace("-", "_"))


def present(kind):
    """The prices that src/plan/profile.c has."""
    with open(PROFILE, encoding="ascii") as file:
        row = re.search(r"\[%s\] = \{(.*?)\}" % enum_name(kind), file.read(), re.S)
    terms = re.findall(r"\[PLAN_TERM_(\w+)\] = ([-0-9.e+]+)", row[1] if row else "")
    return {term.lower().replace("_", " "): float(price) for term, price in terms}


def enter(kind, row):
    """Into src/plan/profile.c, in the place of the row that was there."""
    with open(PROFILE, encoding="ascii") as file:
        text = file.read()
    text, count = re.subn(r"\[%s\] = \{.*?\}" % enum_name(kind), f"[{enum_name(kind)}] = {{ {row} }}", text,
                          flags=re.S)
    if count != 1:
        sys.exit(f"{PROFILE} has no row of {enum_name(kind)}")
    with open(PROFILE, "w", encoding="ascii") as file:
        file.write(text)


def prices(models, only, lean, write):
    kinds = {}
    with tempfile.TemporaryDirectory() as folder:
        runs = [["devices", "--calibrate"]]
        runs += [["report", model, "-o", folder, "--quick", *VIEW[:-1]] for model in models]
        for words in runs:
            for kind, ms, amount in costs(*words):
                kinds.setdefault(kind, []).append((ms, amount))
            print(" ".join(words), file=sys.stderr, flush=True)
    for kind, rows in kinds.items():
        if not kind.startswith(only):
            continue
        found, spread = least_squares(rows, present(kind), lean)
        row = ", ".join(f"[PLAN_TERM_{term.upper().replace(' ', '_')}] = {price:.3g}"
                        for term, price in found.items())
        print(f"    [{enum_name(kind)}] = {{ /* {len(rows)} frames, residual {spread:.0%} */ {row} }},",
              flush=True)
        if write:
            enter(kind, row)
    if write:
        run("clang-format", "-i", PROFILE)


def reports(folder, models):
    os.makedirs(folder, exist_ok=True)
    for model in models:
        name = re.sub(r"\.\w+$", "", os.path.basename(model))
        stipple("report", model, "-o", os.path.join(folder, "report-" + name), *VIEW)
        print(os.path.join(folder, "report-" + name), flush=True)


def main():
    parser = Arguments(__doc__)
    parser.add_argument("what", choices=["auto", "bounds", "features", "prices", "reports"])
    parser.add_argument("arguments", nargs="+", metavar="FILE")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--method", default="exact", help="of features (default: exact)")
    parser.add_argument("--opacity", help="of auto and bounds: everything is so transparent")
    parser.add_argument("--keep", metavar="DIR", help="of auto: the reports stay, as DIR/report-MODEL")
    parser.add_argument("--only", default="", metavar="WORD", help="of prices: kinds that begin so")
    parser.add_argument("--lean", type=float, default=0.0, metavar="L", help="of prices: on those there are")
    parser.add_argument("--write", action="store_true", help="of prices: into src/plan/profile.c")
    options = parser.parse_args()
    files = options.arguments[1:] if options.what == "reports" else options.arguments
    if not files or options.what == "features" and len(files) > 1:
        parser.error(f"{options.what} takes {'DIR FILE...' if not files else 'one FILE'}")
    for file in files:
        if not os.path.exists(file):
            parser.error(f"{file}: no such file")
    if options.rounds < 0 or options.rounds == 0 and options.what != "features":
        parser.error("--rounds is a number from 1 on, of features from 0")
    more = ["--opacity", options.opacity, "--cull", "none"] if options.opacity else []
    if options.what == "auto":
        auto(options.arguments, options.rounds, more, options.keep)
    elif options.what == "bounds":
        bounds(options.arguments, more)
    elif options.what == "features":
        features(options.arguments[0], options.method, options.rounds)
    elif options.what == "prices":
        prices(options.arguments, options.only, options.lean, options.write)
    else:
        reports(options.arguments[0], options.arguments[1:])


if __name__ == "__main__":
    sys.exit(main())
