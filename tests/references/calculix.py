# SPDX-License-Identifier: GPL-3.0-or-later
"""What the references that CalculiX solves (Debian: calculix-ccx) have in common."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest


def graded(first, length, count):
    """count + 1 places from 0 to length, the first step `first`, each longer than the one before by one ratio."""
    low, high = 1.0 + 1e-9, 10.0
    for _ in range(200):
        ratio = (low + high) / 2
        low, high = (ratio, high) if first * (ratio**count - 1) / (ratio - 1) < length else (low, ratio)
    places = [first * (ratio**i - 1) / (ratio - 1) for i in range(count + 1)]
    return [place * length / places[-1] for place in places]


def solve_deck(write, timeout):
    """The words of each line that CalculiX prints for the deck that write(file) writes, within so many seconds. Raises
    RuntimeError if it does not finish the job."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "job.inp"), "w", encoding="ascii") as file:
            write(file)
        run = subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, text=True, timeout=timeout, check=False)
        if "Job finished" not in run.stdout:
            raise RuntimeError(f"ccx failed: {run.stdout[-1000:]}")
        with open(os.path.join(folder, "job.dat"), encoding="ascii") as file:
            return [line.split() for line in file]


def answer_options(doc):
    """Runs the program's tests for --test, or says that they cannot run here; prints `doc` for --help; both end it."""
    if "--test" in sys.argv:
        if shutil.which("ccx") is None:
            print("SKIPPED: CalculiX is missing (Debian: calculix-ccx)")
            sys.exit(0)
        unittest.main(argv=sys.argv[:1])
    if any(word in sys.argv for word in ("-h", "--help")):
        sys.exit(doc)
