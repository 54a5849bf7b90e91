#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that every include between two folders of the project goes in a direction that is allowed.

ROOMS is the whole rule: what a folder may include besides itself. EXCEPTIONS are single includes that break it today,
each with its reason. Prints each violation as file:line, and ends with 1 if there is one."""

import argparse
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# A file belongs to the longest of these paths that it lies in.
PROTOCOL = ["protocol"]
MATH = [*PROTOCOL, "server/math"]
MODELS = [*MATH, "server/models"]
CONSTRAINTS = [*MODELS, "server/constraints", "server/constraints/compliance"]
SCENE = [*MODELS, "server/constraints/compliance", "server/scene"]
SIMULATION = [*CONSTRAINTS, "server/scene", "server/simulation"]
RECORDING = [*SIMULATION, "server/recording"]
RUNTIME = [*RECORDING, "server/runtime"]
TRANSPORT = [*RUNTIME, "server/transport"]
HAPTICS = ["client/haptics", "client/haptics/devices", "client/haptics/program"]
TOOLS = [*TRANSPORT, "server/tools", "client", *HAPTICS]
VIEW = [*PROTOCOL, "client", "client/view"]
ROOMS = {
    "protocol": PROTOCOL,
    "client": [*PROTOCOL, "client"],
    "client/haptics": ["client/haptics"],
    "client/haptics/devices": ["client/haptics", "client/haptics/devices"],
    "client/haptics/program": [*PROTOCOL, "client", *HAPTICS],
    "client/view": VIEW,
    "server/math": MATH,
    "server/models": MODELS,
    "server/constraints/compliance": [*MODELS, "server/constraints/compliance"],
    "server/constraints": CONSTRAINTS,
    "server/scene": SCENE,
    "server/simulation": SIMULATION,
    "server/recording": RECORDING,
    "server/runtime": RUNTIME,
    "server/transport": TRANSPORT,
    "server/main.cpp": TRANSPORT,
    "server/precompiled.cpp": [],
    "server/tools": TOOLS,
    "tests": [*TOOLS, "client/view", "tests"],
}

# (file, what it includes): why.
EXCEPTIONS = {
    ("server/scene/scene.h", "server/constraints/solver/law_method.h"):
        "a scene names the solver of its laws; the header includes nothing of the project",
}

INCLUDE = re.compile(r'\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')
TOP_FOLDERS = sorted({room.split("/")[0] for room in ROOMS})


def room_of(path):
    """The room of a file, None if it has none."""
    fitting = [room for room in ROOMS if path == room or path.startswith(room + "/")]
    return max(fitting, key=len, default=None)


def sources(root):
    """Paths of all C++ files, relative to the root."""
    for top in TOP_FOLDERS:
        for folder, folders, files in os.walk(os.path.join(root, top)):
            folders.sort()
            for name in sorted(files):
                if name.endswith((".h", ".cpp")):
                    yield os.path.relpath(os.path.join(folder, name), root)


def includes(root, path):
    """The project's own files that a file includes, each with its line; quotes may name a file beside it, too."""
    with open(os.path.join(root, path), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            beside = os.path.normpath(os.path.join(os.path.dirname(path), match[1])) if match[1] else None
            for candidate in (beside, os.path.normpath(match[1] or match[2])):
                known = candidate and candidate.split("/")[0] in TOP_FOLDERS
                if known and os.path.isfile(os.path.join(root, candidate)):
                    yield number, candidate
                    break


def fault(path, included):
    """Why a file may not include another, None if it may."""
    room, other = room_of(path), room_of(included)
    if room is None or other is None:
        homeless = path if room is None else included
        return f"{homeless} lies in no folder of ROOMS; move it to one, or say there what the new folder may include"
    if other in ROOMS[room] or path == included:
        return None
    allowed = ", ".join(each for each in ROOMS[room] if each != room) or "nothing of the project"
    return f"{room} may include {allowed}, but not {other}"


def violations(root, exceptions):
    """Messages, one for each include in a direction that is not allowed and for each exception that nothing needs."""
    found, used = [], set()
    for path in sources(root):
        for line, included in includes(root, path):
            why = fault(path, included)
            if why and (path, included) in exceptions:
                used.add((path, included))
            elif why:
                found.append(f"{path}:{line}: includes {included}: {why}")
    for path, included in sorted(set(exceptions) - used):
        found.append(f"{path}: no longer includes {included}: remove that exception from {os.path.basename(__file__)}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", nargs="?", default=ROOT, help="of the sources (default: here)")
    root = parser.parse_args().root
    if not any(True for _ in sources(root)):
        sys.exit(f"{root}: expected folders with C++ files ({', '.join(TOP_FOLDERS)}), found none")
    found = violations(root, EXCEPTIONS)
    print("\n".join(found) if found else "all includes go in allowed directions")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
