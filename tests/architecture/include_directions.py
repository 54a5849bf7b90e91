#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that every include between two folders of the project goes in a direction that is allowed.

Inside the engine a folder may include what its target links, as server/engine/CMakeLists.txt says: ENGINE_ROOMS is the file
that CMake writes of it, a line "FOLDER: FOLDER..." each. `rooms` is the rule for all others. EXCEPTIONS are single includes
that break it today, each with its reason. Prints each violation as file:line, and ends with 1 if there is one."""

import argparse
import os
import re
import sys



def rooms(engine_rooms):
    """What a folder may include, itself among it. A file belongs to the longest of these paths that it lies in."""
    protocol = ["protocol"]
    found = {}
    for line in engine_rooms.splitlines():
        name, links = line.split(":")
        found["server/engine/" + name] = [*protocol, *("server/engine/" + each for each in (name, *links.split()))]
    runtime = [*protocol, *found, "server/runtime"]
    transport = [*runtime, "server/transport"]
    haptics = ["client/haptics", "client/haptics/devices", "client/haptics/program"]
    client = [*protocol, "client/link", "client/replay"]
    programs = [*transport, "server/export", *client, *haptics]
    return found | {
        "protocol": protocol,
        "client/link": [*protocol, "client/link"],
        "client/replay": client,
        "client/haptics": ["client/haptics"],
        "client/haptics/devices": ["client/haptics", "client/haptics/devices"],
        "client/haptics/program": [*client, *haptics],
        "client/view": [*protocol, "client/link", "client/view"],
        "server/engine/example": [*found],
        "server/engine/python": [*protocol, *found, "server/engine/python"],
        "server/runtime": runtime,
        "server/transport": transport,
        "server/main.cpp": transport,
        "server/precompiled.cpp": [],
        "server/export": [*transport, "server/export", *client],
        "tests/study": [*programs, "tests/study"],
        "tests/study/tests": [*programs, "tests", "tests/study", "tests/study/tests"],
        "tests": [*programs, "client/view", "tests", "tests/study"],
    }


# (file, what it includes): why.
EXCEPTIONS = {("client/haptics/message.h", "protocol/messages.h"): "the one header of the kit that knows messages"}

INCLUDE = re.compile(r'\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')
TOP_FOLDERS = ["client", "protocol", "server", "tests"]


def room_of(path, allowed):
    """The room of a file, None if it has none."""
    fitting = [room for room in allowed if path == room or path.startswith(room + "/")]
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


def fault(path, included, allowed):
    """Why a file may not include another, None if it may."""
    room, other = room_of(path, allowed), room_of(included, allowed)
    if room is None or other is None:
        homeless = path if room is None else included
        return f"{homeless} lies in no folder of rooms(); move it to one, or say there what the new folder may include"
    if other in allowed[room] or path == included:
        return None
    others = ", ".join(each for each in allowed[room] if each != room) or "nothing of the project"
    return f"{room} may include {others}, but not {other}"


def violations(root, allowed, exceptions):
    """Messages, one for each include in a direction that is not allowed and for each exception that nothing needs."""
    found, used = [], set()
    for path in sources(root):
        for line, included in includes(root, path):
            why = fault(path, included, allowed)
            if why and (path, included) in exceptions:
                used.add((path, included))
            elif why:
                found.append(f"{path}:{line}: includes {included}: {why}")
    for path, included in sorted(set(exceptions) - used):
        found.append(f"{path}: no longer includes {included}: remove that exception from {os.path.basename(__file__)}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", help="of the sources")
    parser.add_argument("engine_rooms", metavar="ENGINE_ROOMS", help="file that CMake writes into the build")
    arguments = parser.parse_args()
    root = arguments.root
    with open(arguments.engine_rooms, encoding="utf-8") as file:
        allowed = rooms(file.read())
    if not any(True for _ in sources(root)):
        sys.exit(f"{root}: expected folders with C++ files ({', '.join(TOP_FOLDERS)}), found none")
    found = violations(root, allowed, EXCEPTIONS)
    print("\n".join(found) if found else "all includes go in allowed directions")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
