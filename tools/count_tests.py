#!/usr/bin/env python3
"""Adds up meson's testlog.json files: only OK and an expected failure pass. A skip, a timeout and
a log that is missing are failures, so that nothing goes by in silence.

  tools/count_tests.py LOG...    ends with "N passed, N failed"; exit status 1 when any failed
"""
import json
import sys

from command_line import Arguments


def results(path):
    """(name, result) of each test."""
    try:
        with open(path, encoding="utf-8") as log:
            lines = [json.loads(line) for line in log if line.strip()]
    except (OSError, ValueError) as error:
        return [(f"{path}: {error}", "NO LOG")]
    return [(test["name"], test["result"]) for test in lines] or [(path, "EMPTY LOG")]


def main():
    parser = Arguments(__doc__)
    parser.add_argument("logs", nargs="+", metavar="LOG")
    tests = [test for path in parser.parse_args().logs for test in results(path)]
    failed = [test for test in tests if test[1] not in ("OK", "EXPECTEDFAIL")]
    for name, result in failed:
        print(f"{result}: {name}")
    print(f"{len(tests) - len(failed)} passed, {len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
