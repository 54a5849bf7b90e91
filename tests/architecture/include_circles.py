#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that no sources need each other, and that no folder of the engine holds too many.

A source is a header with its .cpp: what one of them includes, both need. Prints each circle of sources, and each folder of
server/engine with more than MOST sources; ends with 1 if there is one."""

import argparse
import collections
import os
import sys

from include_directions import includes, sources

MOST = 12


def stem(path):
    return os.path.splitext(path)[0]


def graph(root):
    """What each source needs."""
    needs = {}
    for path in sources(root):
        of = needs.setdefault(stem(path), set())
        of.update(stem(included) for _, included in includes(root, path) if stem(included) != stem(path))
    return needs


def circles(needs):
    """Sets of sources that need each other, by Tarjan's algorithm."""
    order, low, stack, found = {}, {}, [], []

    def visit(source):
        order[source] = low[source] = len(order)
        stack.append(source)
        for other in sorted(needs.get(source, ())):
            if other not in order:
                visit(other)
                low[source] = min(low[source], low[other])
            elif other in stack:
                low[source] = min(low[source], order[other])
        if low[source] == order[source]:
            circle = stack[stack.index(source):]
            del stack[stack.index(source):]
            if len(circle) > 1:
                found.append(sorted(circle))

    sys.setrecursionlimit(max(sys.getrecursionlimit(), 10 * len(needs) + 1000))
    for source in sorted(needs):
        if source not in order:
            visit(source)
    return found


def crowded(needs):
    """(folder, its sources, how many it may have) of each folder of the engine that has more."""
    count = collections.Counter(os.path.dirname(source) for source in needs if source.startswith("server/engine/"))
    return [(folder, number, MOST) for folder, number in sorted(count.items()) if number > MOST]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", help="of the sources")
    needs = graph(parser.parse_args().root)
    if not needs:
        sys.exit("no C++ files there")
    found = [f"need each other: {', '.join(circle)}; move what they share into a third, or make one of them" for circle in circles(needs)]
    found += [f"{folder}: {number} sources, expected at most {most}; give those of one idea a folder" for folder, number, most in crowded(needs)]
    print("\n".join(found) if found else "no circles, no crowded folders")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
