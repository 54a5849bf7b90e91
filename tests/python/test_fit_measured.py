# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.fit at length: twenty truths, with noise, found again; gelatin as it was measured, what is fitted told from what is
predicted. Prints what it finds. Measured data are looked for in ../shared/data."""

import csv
import math
import os
import unittest

import numpy as np
from small_scene import ROOT, InTemporaryFolder
from test_fit import CUTTING, PUNCTURE, PUSH, STIFFNESS, with_truth

import acus
from acus import engine
from acus.fit import Fit, Measurement, simulated

DATA = os.path.join(os.path.dirname(ROOT), "shared", "data")
GELATIN = "tissue.regions[gelatin].material.young_modulus"
CLEARANCE = 0.01  # m, of the needle above the gelatin, in the scene


def needs(name):
    path = os.path.join(DATA, name)
    return unittest.skipUnless(os.path.exists(path), f"without {path}")


@unittest.skipUnless(engine.available(), "without the engine")
class Truths(InTemporaryFolder):
    def test_twenty(self):
        """Each with noise of 1 % of its range."""
        scene = acus.Scene.read(self.write_scene())
        ranges = {STIFFNESS: (2e3, 30e3), PUNCTURE: (0.1, 1.0), CUTTING: (0.03, 0.6)}
        random, errors, inside, doubts = np.random.default_rng(7), [], 0, 0
        for case in range(20):
            truth = {name: float(math.exp(random.uniform(math.log(1.3 * low), math.log(0.77 * high)))) for name, (low, high) in ranges.items()}
            truth[CUTTING] = min(truth[CUTTING], 0.6 * truth[PUNCTURE])  # above, a tip does not puncture but cuts
            noise = 0.01 * simulated(with_truth(scene, truth), PUSH).size
            data = simulated(with_truth(scene, truth), PUSH, noise=noise, seed=case)
            done = Fit(scene, data, ranges).run(progress=False)
            for name, value in truth.items():
                low, high = done.intervals[name]
                errors.append(abs(done.values[name] / value - 1))
                inside += low <= value <= high
                doubts += name in done.doubts
        print(f"20 truths: errors median {np.median(errors):.2%}, largest {max(errors):.2%}; {inside} of 60 within their intervals; {doubts} not identified")
        self.assertLess(np.median(errors), 0.01)
        self.assertLess(max(errors), 0.1)
        self.assertGreaterEqual(inside, 51)
        self.assertEqual(doubts, 0)


@unittest.skipUnless(engine.available(), "without the engine")
class Measured(unittest.TestCase):
    @needs("bevel_steering/timeseries.csv")
    def test_gelatin(self):
        """Three insertions fitted together, four predicted."""
        trials = gelatin_trials()
        scene = acus.Scene.read(acus.find_scene("steering_arc"))
        done = Fit(scene, trials[:3], {GELATIN: (10e3, 300e3)}).run(progress=False)
        print(done)
        predicted = [done.predict(each) for each in trials[3:]]
        print(*predicted, sep="\n")
        self.assertEqual(done.doubts, {})
        self.assertLess(np.median([each.relative for each in predicted]), 0.15)


def gelatin_trials():
    """A Measurement of each insertion into gelatin without steering: how far the tip is off, over its depth."""
    with open(os.path.join(DATA, "bevel_steering", "timeseries.csv"), newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["medium"] == "gelatin4" and row["mode"] == "open"]
    push, trials = acus.Insertion(0.11, 0.02), []
    for name in sorted({row["trial"] for row in rows}):
        x, off = np.array([[-float(row["tip_y_mm"]), math.hypot(float(row["tip_x_mm"]) - float(row["guide_x_mm"]),
                                                                  float(row["tip_z_mm"]) - float(row["guide_z_mm"]))]
                           for row in rows if row["trial"] == name]).T / 1e3
        trials.append(Measurement(x + CLEARANCE, off - np.mean(off[x <= 5e-3]), "travel", "deflection", push, name=name))
    return trials


if __name__ == "__main__":
    unittest.main()
