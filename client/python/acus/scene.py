# SPDX-License-Identifier: MIT
"""Scenes in Python: read, built, edited, checked, and written as text for the server.

The format is acus-server's to know: it reads YAML, checks a scene, and tells the schema. Here a scene is what stands in
the file, as dictionaries and lists, and a field is named as in the messages of the programs:
tissue.regions[0].material.young_modulus. A region, needle or guide may be named instead of counted:
needles[left].length.
"""

import copy
import difflib
import functools
import json
import math
import os
import re
import subprocess
import tempfile

import numpy as np

from . import own_files
from .errors import ProgramNotFound, SceneError
from .programs import find_server, scene_path

PLACE = re.compile(r"\.?([A-Za-z_]+)|\[([^\]]+)\]")
MESH_FILE = ("tissue", "mesh", "gmsh", "file")


class Scene:
    """`fields` are the scene's, nested as in a file; without any it is an empty one of the newest format. `folder` is
    where mesh files are looked up, that of the scene's file."""

    def __init__(self, fields=None, folder=None):
        self.fields = {"acus_scene": 1, **copy.deepcopy(dict(fields or {}))}
        self.folder = None if folder is None else os.path.abspath(folder)

    @classmethod
    def read(cls, path):
        """Of a file, or of a scene of the project by its name. Raises SceneError as the server would, but for what is wrong
        with its mesh."""
        path = file_of(path)
        return cls(json.loads(ask_acus_server("--json", path)), os.path.dirname(os.path.abspath(path)))

    @staticmethod
    @functools.cache
    def schema():
        """The JSON Schema of scenes: types, ranges, defaults, and meanings with units."""
        return json.loads(ask_acus_server("--schema"))

    def __repr__(self):
        tissue = self.fields.get("tissue") or {}
        counts = [(tissue.get("regions"), "region"), (self.fields.get("needles"), "needle"), (self.fields.get("guides"), "guide")]
        told = [counted_in_words(len(each), what) for each, what in counts if isinstance(each, list)]
        return f"<Scene {self.fields.get('name', 'scene')!r}{': ' if told else ''}{', '.join(told)}>"

    def copy(self):
        return Scene(self.fields, self.folder)

    def __getitem__(self, place):
        """The value at a place; the default where the scene does not give one. Raises SceneError if there is none."""
        value, schema = self.fields, self.schema()
        for depth, step in enumerate(steps := steps_of(place)):
            schema = schema_within(schema, step, steps, depth)
            value = value_within(value, step, steps, depth)
            if value is None:
                return self._default(schema, steps, depth)
        return value

    def __setitem__(self, place, value):
        """Maps on the way that the scene does not have are made; entries of lists are not."""
        *parents, last = steps = steps_of(place)
        inside = self.fields
        for depth, step in enumerate(parents):
            if isinstance(step, str) and isinstance(inside, dict):
                inside = inside.setdefault(step, {})
            else:
                inside = value_within(inside, step, steps, depth)
                if inside is None:
                    raise SceneError(f"{shown(steps[:depth + 1])}: the scene has no such entry")
        if isinstance(last, str) and isinstance(inside, dict):
            inside[last] = plain(value)
        else:
            inside[index_of(inside, last, steps)] = plain(value)

    def schema_at(self, place):
        """The schema of a field, whose entries of lists the scene has. Raises SceneError, with fields of the same name
        where there is none."""
        schema, value = self.schema(), self.fields
        for depth, step in enumerate(steps := steps_of(place)):
            try:
                schema = schema_within(schema, step, steps, depth)
            except SceneError as error:
                raise SceneError(f"{error}{did_you_mean(place, self.schema())}") from None
            value = value_within(value, step, steps, depth)
        return schema

    def counted(self, place):
        """The place with numbers instead of names: regions[skin] as regions[0]. Raises SceneError."""
        value, found = self.fields, []
        for depth, step in enumerate(steps := steps_of(place)):
            found.append(step if isinstance(step, str) else index_of(value, step, steps[:depth + 1]))
            value = value_within(value, step, steps, depth)
        return shown(found)

    def __contains__(self, place):
        """Whether the scene itself gives a value there."""
        value = self.fields
        for depth, step in enumerate(steps := steps_of(place)):
            value = value_within(value, step, steps, depth)
            if value is None:
                return False
        return True

    def add(self, place, fields):
        """One more entry of a list, such as needles, which is begun if need be. The place of the entry."""
        entries = list(self[place]) if place in self else []
        self[place] = [*entries, fields]
        return f"{place}[{len(entries)}]"

    def check(self):
        """Raises SceneError if the server could not use it, with the field's place; the mesh is not looked into. The
        scene itself."""
        with tempfile.NamedTemporaryFile("w", suffix=".yaml", encoding="utf-8") as file:
            file.write(self.text())
            file.flush()
            ask_acus_server("--json", file.name, shown_as="scene")
        return self

    def text(self):
        """As YAML, which the server reads. Mesh files have whole paths."""
        fields = copy.deepcopy(self.fields)
        *parents, last = MESH_FILE
        inside = fields
        for name in parents:
            inside = inside.get(name, {}) if isinstance(inside, dict) else {}
        if self.folder and isinstance(inside, dict) and isinstance(inside.get(last), str):
            inside[last] = os.path.join(self.folder, inside[last])
        return yaml(fields)

    def save(self, path, replace=False):
        """Writes text() to a file. One that is there is replaced where save() wrote it and nobody has edited it since; with
        `replace` any. Raises SceneError."""
        own_files.write(path, own_files.sealed(self.text()), (lambda _: True) if replace else own_files.is_sealed, SceneError,
                        "give another name, or replace=True")

    @staticmethod
    def _default(schema, steps, depth):
        for step in steps[depth + 1:]:
            schema = schema_within(schema, step, steps, depth)
        if "default" not in schema:
            raise SceneError(f"{shown(steps)}: the scene does not give it, and it has no default")
        return copy.deepcopy(schema["default"])


def file_of(given):
    """A scene's file by path or name. Raises SceneError."""
    try:
        return scene_path(given)
    except ProgramNotFound as error:
        raise SceneError(str(error)) from None


def counted_in_words(count, what):
    return f"{count} {what}" + ("" if count == 1 else "s")


def ask_acus_server(*arguments, shown_as=None):
    done = subprocess.run([find_server(), *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        message = done.stderr.strip()
        if shown_as:  # the file was made for the program
            message = message.replace(arguments[-1], shown_as, 1)
        raise SceneError(message)
    return done.stdout


def steps_of(place):
    """a.b[0].c as ["a", "b", 0, "c"]; what is in brackets and no number is a name, kept as a 1-tuple."""
    steps, end = [], 0
    for found in PLACE.finditer(place):
        if found.start() != end:
            break
        end = found.end()
        field, entry = found.groups()
        steps.append(field if field else int(entry) if entry.isdigit() else (entry,))
    if end != len(place) or not steps:
        raise SceneError(f"'{place}': expected the place of a field, such as needles[0].base.position")
    return steps


def shown(steps):
    """As the programs name it."""
    text = "".join("." + step if isinstance(step, str) else f"[{step[0] if isinstance(step, tuple) else step}]"
                   for step in steps)
    return text.removeprefix(".")


def value_within(value, step, steps, depth):
    """None where the scene has no such value."""
    if isinstance(step, str):
        return value.get(step) if isinstance(value, dict) else None
    return value[index_of(value, step, steps[:depth + 1])]


def index_of(entries, step, steps):
    if not isinstance(entries, list):
        raise SceneError(f"{shown(steps)}: the scene has no list there")
    if isinstance(step, tuple):
        names = [each.get("name") if isinstance(each, dict) else None for each in entries]
        if step[0] in names:
            return names.index(step[0])
    elif isinstance(step, int) and step < len(entries):
        return step
    names = [each["name"] for each in entries if isinstance(each, dict) and "name" in each]
    has = f"; it has {', '.join(names)}" if names else f"; it has {len(entries)}"
    raise SceneError(f"{shown(steps)}: the scene has no such entry{has}")


def schema_within(schema, step, steps, depth):
    inside = schema.get("properties", {}).get(step) if isinstance(step, str) else schema.get("items")
    if inside is None:
        raise SceneError(f"{shown(steps[:depth + 1])}: scenes have no such field")
    return inside


def did_you_mean(place, schema, most=3):
    """The places whose last field has this name, or one like it."""
    name = place.rpartition(".")[2]
    names = {each.rpartition(".")[2] for each in places_in(schema)}
    like = difflib.get_close_matches(name, names, 1, 0.8) or sorted(each for each in names if each.startswith(name))
    found = [each for each in places_in(schema) if like and each.rpartition(".")[2] == like[0]]
    found.sort(key=len)
    return "; did you mean " + " or ".join(found[:most]) + "?" if found else ""


def places_in(schema, before=""):
    """Of all fields, with the first entry of each list."""
    for name, inside in schema.get("properties", {}).items():
        place = f"{before}.{name}".removeprefix(".")
        yield place
        yield from places_in(inside, place)
        if "properties" in inside.get("items", {}):
            yield from places_in(inside["items"], place + "[0]")


# ---- YAML 1.2 ----


def plain(value):
    """Without numpy's types."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, dict):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def yaml(value):
    """Block style for maps and lists of maps, flow style for what fits on a line."""
    return "".join(f"{name}: {block(each, 1)}\n" for name, each in plain(value).items())


def block(value, depth):
    indent = "\n" + "  " * depth
    if isinstance(value, dict) and value:
        return "".join(f"{indent}{scalar(name)}: {block(each, depth + 1)}" for name, each in value.items())
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return "".join(f"{indent}- {flow(each)}" for each in value)
    return flow(value)


def flow(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(name)}: {flow(each)}" for name, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(flow(each) for each in value) + "]"
    return scalar(value)


def scalar(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        is_plain = re.fullmatch(r"[a-z_]+", value) and value not in ("true", "false", "null")
        return value if is_plain else json.dumps(value)
    if isinstance(value, (int, float)):
        if math.isinf(value):
            return "-.inf" if value < 0 else ".inf"
        return repr(value)
    raise SceneError(f"expected numbers, texts, lists and maps in a scene, found {value!r}")
