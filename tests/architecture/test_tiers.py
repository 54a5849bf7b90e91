#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every test is in one tier, and the tiers are what CONTRIBUTING.md says of them. Of the build in $ACUS_BUILD."""

import json
import os
import subprocess
import unittest

BUILD = os.environ["ACUS_BUILD"]
TIERS = {"fast", "gate", "clock", "full"}
LONGEST_FAST = 2.0  # s, four times what CONTRIBUTING.md says, as other tests run beside
MOST_CLOCK = 12


def tests():
    """name: properties"""
    listed = subprocess.run([os.environ["ACUS_CTEST"], "--test-dir", BUILD, "--show-only=json-v1"], check=True,
                            stdout=subprocess.PIPE).stdout
    return {test["name"]: {each["name"]: each["value"] for each in test["properties"]}
            for test in json.loads(listed)["tests"]}


def mean_times():
    """name: s, over the runs in this build so far; CTest keeps them"""
    path = os.path.join(BUILD, "Testing", "Temporary", "CTestCostData.txt")
    times = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            for line in file:
                if line.startswith("---"):
                    break
                name, runs, seconds = line.rsplit(maxsplit=2)
                if int(runs) > 0:
                    times[name] = float(seconds)
    return times


class Tiers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tests = tests()

    def of_tier(self, tier):
        return [name for name, properties in self.tests.items() if properties.get("LABELS") == [tier]]

    def test_every_test_has_one_tier(self):
        self.assertGreater(len(self.tests), 500)
        wrong = {name: properties.get("LABELS") for name, properties in self.tests.items()
                 if len(properties.get("LABELS", [])) != 1 or properties["LABELS"][0] not in TIERS}
        self.assertEqual(wrong, {})

    def test_few_see_the_clock_and_they_run_alone(self):
        clock = self.of_tier("clock")
        self.assertLessEqual(len(clock), MOST_CLOCK)
        self.assertEqual([name for name in clock if not self.tests[name].get("RUN_SERIAL")], [])

    def test_fast_ones_are_fast(self):
        times = mean_times()
        slow = {name: times[name] for name in self.of_tier("fast") if times.get(name, 0) > LONGEST_FAST}
        self.assertEqual(slow, {})


if __name__ == "__main__":
    unittest.main(verbosity=2)
