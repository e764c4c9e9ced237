"""What the programs of this folder share: their arguments, and the programs that they run."""
import argparse
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
STIPPLE = os.path.join(ROOT, "build", "tools", "stipple")


class Arguments(argparse.ArgumentParser):
    """A program's text is its help. Wrong arguments are one line, and exit status 2."""
    def __init__(self, text):
        super().__init__(description=text.strip(),
                         formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message} (--help says what there is)\n")


def positive(text):
    """For type=: a whole number from 1 on."""
    if int(text) < 1:
        raise ValueError
    return int(text)


def existing(text):
    """For type=: a file or folder that is there."""
    if not os.path.exists(text):
        raise argparse.ArgumentTypeError(f"{text}: no such file")
    return text


class Failed(SystemExit):
    """A program failed. Who does not catch this ends, with what it said and its exit status."""
    def __init__(self, words, said, why):
        super().__init__("\n".join([*said, f"{os.path.basename(sys.argv[0])}: {why}: {' '.join(words)}"]))
        self.said = said


def run(*words):
    """Runs a program to its end; its output is in what comes back."""
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Failed(words, [], error.strerror) from None
    if done.returncode:
        raise Failed(words, done.stderr.splitlines(), f"exit status {done.returncode}")
    return done


def stipple(*words):
    """What the command prints."""
    return run(STIPPLE, *words).stdout
