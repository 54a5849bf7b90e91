#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a CTest entry PREFIX.<case> for each test case of a test program; runs when the program has been linked.

usage: discover_tests.py PROGRAM PREFIX TIER SKIPPED OUTPUT

The label of an entry, one of the tiers of CONTRIBUTING.md, is the doctest suite of its case, or TIER where it has none. Cases that doctest skips have no entry.
"""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree

# What may take long starts first. What has to see a real clock runs alone.
PROPERTIES = {
    "fast": "TIMEOUT 60",
    "gate": "TIMEOUT 300 COST 10",
    "clock": "TIMEOUT 300 COST 20 RUN_SERIAL TRUE",
    "full": "TIMEOUT 7200 COST 100",
}


def bracket(text):
    """text as an argument of CMake, whatever it contains"""
    return f"[==[{text}]==]"


def entry(program, prefix, tier, skipped, case):
    tier = case.get("testsuite") or tier
    name = case.get("name")
    if tier not in PROPERTIES:
        sys.exit(f"{prefix}.{name}: '{tier}' is no tier; a doctest suite is one of {', '.join(PROPERTIES)}")
    only = "--test-case=" + name.replace(",", "\\,")
    return (
        f"add_test({bracket(f'{prefix}.{name}')} {bracket(program)} {bracket(only)})\n"
        f"set_tests_properties({bracket(f'{prefix}.{name}')} PROPERTIES LABELS {tier} {PROPERTIES[tier]}\n"
        f"  SKIP_REGULAR_EXPRESSION {bracket(skipped)})\n"
    )


def main():
    program, prefix, tier, skipped, output = sys.argv[1:]
    listed = subprocess.run([program, "--list-test-cases", "--reporters=xml"], check=True, stdout=subprocess.PIPE).stdout
    cases = [case for case in ElementTree.fromstring(listed).iter("TestCase") if case.get("skipped") != "true"]
    if not cases:
        sys.exit(f"{program} lists no test cases")
    with open(output, "w", encoding="utf-8") as file:
        file.writelines(entry(program, prefix, tier, skipped, case) for case in cases)


main()
