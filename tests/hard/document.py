#!/usr/bin/env python3
"""Renews the tables and pictures of docs/hard-cases.md from measurements.

usage: document.py PROGRAM [FAMILY...]

PROGRAM is the build's tests/hard/hard. Of the families named, or of all: what stands between `<!-- FAMILY -->` and `<!-- end -->` is
replaced by the rows that the program prints for that family; pictures go to docs/images/hard.
"""
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "hard-cases.md")
PICTURES = os.path.join(ROOT, "docs", "images", "hard")
CASES = ("| case, and what must come out | | exact | exact, ids | two-pass compute | two-pass raster "
         "| deferred compute | deferred raster | truth |\n|---|---|---:|---:|---:|---:|---:|---:|---|\n")
BREAK = "| how | dB | ms | eight times the error |\n|---|---:|---:|---|\n"
SAMPLES = "| samples | exact | two-pass |\n|---:|---:|---:|\n"
LAYERS = ("| case, and what must come out | | exact | exact, ids | peel | nearest | fast | truth |\n"
          "|---|---|---:|---:|---:|---:|---:|---|\n")
AXIS = ("| case, and what must come out | | blend | clip | single | sort | of its bound |\n"
        "|---|---|---:|---:|---:|---:|---:|\n")
PYRAMID = ("| case | is | | covered | lost | empty | wider | behind | dB | twin |\n"
           "|---|---|---|---:|---:|---:|---:|---:|---:|---|\n")
HEADS = {"breaks": BREAK, "samples": SAMPLES, "layers": LAYERS, "axis": AXIS, "axis_surface": AXIS, "pyramid": PYRAMID}


def rows(program, family):
    """The rows of a family; of breaks, every case has a table of its own."""
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "table")
        run = subprocess.run([program, "--family", family, "--table", table,
                              "--pictures", PICTURES],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if run.returncode:
            print(run.stdout, f"document: {family} does not hold", sep="", file=sys.stderr)
            return None
        with open(table, encoding="utf-8") as file:
            return file.read()


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program, wanted = sys.argv[1], sys.argv[2:]
    os.makedirs(PICTURES, exist_ok=True)
    with open(PAGE, encoding="utf-8") as file:
        page = file.read()
    failed = False
    for family in re.findall(r"<!-- (\w+) -->\n", page):
        if family == "end" or (wanted and family not in wanted):
            continue
        measured = rows(program, family)
        if measured is None:
            failed = True
            continue
        text = HEADS.get(family, CASES) + measured
        page = re.sub(rf"(<!-- {family} -->\n).*?(<!-- end -->)",
                      lambda m, t=text: m.group(1) + t + m.group(2), page, flags=re.S)
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(page)
        print(family, flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
