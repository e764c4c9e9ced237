#!/usr/bin/env python3
"""The manual page says what --help says, and is clean roff.

The lists of options in docs/stipple.1 stand between marks and are made from --help; this test
compares them. usage: manual.py STIPPLE [--update]    --update writes them anew
"""
import os
import re
import subprocess
import sys

import tree

PAGE = os.path.join(tree.ROOT, "docs", "stipple.1")
COMMANDS = ["info", "render", "plan", "prepare", "compare", "report", "devices"]
OPTION = re.compile(r"  (?:(-\w), |    )(--[\w-]+)(?: (\S+))?(?:  +(.*))?$")


def parse_help(output):
    """[(heading, letter, name, argument, text)] of one command's --help."""
    options, heading = [], None
    for line in output.splitlines():
        if re.match(r"[A-Z]\w+:$", line):
            heading = line[:-1]
        elif OPTION.match(line) and heading != "Examples":
            letter, name, argument, text = OPTION.match(line).groups()
            options.append([heading, letter, name, argument, text or ""])
        elif line.startswith(" " * 26) and options:
            options[-1][4] += " " + line.strip()
    return [(h, l, n, a, t.strip()) for h, l, n, a, t in options]


def roff(text):
    return text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("^", "\\(ha")


def entry(option, commands):
    _, letter, name, argument, text = option
    label = f"\\fB{roff(letter)}\\fR, " if letter else ""
    label += f"\\fB{roff(name)}\\fR"
    label += f" \\fI{roff(argument)}\\fR" if argument else ""
    takers = "" if len(commands) == len(COMMANDS) else f" [{', '.join(commands)}]"
    return [".TP", label, roff(text + "." + takers)]


def option_lists(tool):
    """All commands' options, each once, under its heading, with the commands that take it."""
    takers = {}
    for command in ["render"] + [c for c in COMMANDS if c != "render"]:
        run = subprocess.run([tool, command, "--help"], capture_output=True, text=True, check=True)
        for option in parse_help(run.stdout):
            takers.setdefault(option, []).append(command)
    headings = list(dict.fromkeys(option[0] for option in takers))
    headings.sort(key=lambda h: h == "General")
    lines = []
    for heading in headings:
        lines.append(f".SS {heading}")
        for option, commands in takers.items():
            if option[0] == heading:
                lines += entry(option, [c for c in COMMANDS if c in commands])
    return len(takers), lines


def roff_warnings():
    run = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z", PAGE],
                         capture_output=True, text=True, env={**os.environ, "MANWIDTH": "80"})
    return [run.stderr] if run.stderr or run.returncode else []


def main(tool, update=None):
    before, begin, rest = tree.text(PAGE).partition('.\\" options: made from --help\n')
    made, end, after = rest.partition('.\\" end of options\n')
    count, lines = option_lists(tool)
    wanted = "\n".join(lines) + "\n"
    if update == "--update":
        with open(PAGE, "w", encoding="utf-8") as page:
            page.write(before + begin + wanted + end + after)
        made = wanted
    faults = roff_warnings()
    if made != wanted or not end:
        faults.append("docs/stipple.1 differs from --help; run tests/lint/manual.py STIPPLE --update")
    tree.finish(count, faults)


main(*sys.argv[1:])
