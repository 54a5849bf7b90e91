# SPDX-License-Identifier: MIT
"""Where the programs of Acus are: named, in $ACUS_SERVER, in the build of the checkout that this package lies in, or on
PATH. All others are looked for beside acus-server first."""

import glob
import os
import shutil

from .errors import ProgramNotFound

CHECKOUT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
OF_PIP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "scenes")  # there where pip has installed the package
REMEDY = ("this package is Python alone: build the server in a checkout (scripts/build) or install its Debian package "
          "(scripts/package, apt install ./acus-server_*.deb), and say by $ACUS_SERVER where it is if it is not on PATH")
PREFERRED = "release"  # preset; else what was built last


def find_server(program=None):
    """Path of acus-server; raises ProgramNotFound."""
    for found in (program, os.environ.get("ACUS_SERVER")):
        if found:
            return checked(found)
    found = newest_build("acus-server") or shutil.which("acus-server")
    if not found:
        raise ProgramNotFound("acus-server is neither in the build of this checkout nor on PATH; " + REMEDY)
    return found


def find_program(name, server=None):
    """Path of acus-export and the like; raises ProgramNotFound."""
    try:
        beside = os.path.join(os.path.dirname(find_server(server)), name)
    except ProgramNotFound:
        beside = ""
    if is_program(beside):
        return beside
    found = newest_build(name) or shutil.which(name)
    if not found:
        raise ProgramNotFound(f"{name} is neither beside acus-server nor on PATH")
    return found


def find_scene(name):
    """The file of a scene of the project, in the checkout or where it is installed; raises ProgramNotFound."""
    folders = [os.path.join(CHECKOUT, "scenes"), OF_PIP]
    try:
        folders.append(os.path.join(os.path.dirname(os.path.dirname(find_server())), "share", "acus", "scenes"))
    except ProgramNotFound:
        pass
    for folder in [*folders, "/usr/share/acus/scenes"]:
        path = os.path.join(folder, name + ".yaml")
        if os.path.exists(path):
            return path
    known = sorted({each.removesuffix(".yaml") for folder in folders if os.path.isdir(folder) for each in os.listdir(folder) if each.endswith(".yaml")})
    there = f"there are {', '.join(known)}" if known else "there are none: install the package acus-scenes"
    raise ProgramNotFound(f"no scene '{name}': neither a file nor one of the project; {there}")


def scene_path(given):
    """A scene's file by path, or by the name of one of the project, as acus-server takes it. Raises ProgramNotFound for a
    name of none."""
    path = os.fsdecode(given)
    return path if os.path.exists(path) or os.sep in path or path.endswith(".yaml") else find_scene(path)


def newest_build(name):
    programs = [path for path in glob.glob(os.path.join(CHECKOUT, "build", "*", "bin", name)) if is_program(path)]
    preferred = os.path.join(CHECKOUT, "build", PREFERRED, "bin", name)
    return preferred if preferred in programs else max(programs, key=os.path.getmtime, default=None)


def checked(path):
    found = shutil.which(path)  # also a name on PATH
    if not found:
        raise ProgramNotFound(f"'{path}' is no program that can be run")
    return found


def is_program(path):
    return os.path.isfile(path) and os.access(path, os.X_OK)
