# SPDX-License-Identifier: MIT
"""Checks of what users give, and hashes of it."""

import dataclasses
import functools
import hashlib
import inspect
import math
import os
import sys
import types

import numpy as np

from ..errors import StudyError


def check_number(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not math.isfinite(value):
        raise StudyError(f"{name}: expected a finite number, found {value!r}")


def check_vector(name, value):
    """3 numbers as a tuple."""
    try:
        vector = tuple(float(each) for each in value)
    except (TypeError, ValueError):
        vector = ()
    if len(vector) != 3 or not all(map(math.isfinite, vector)):
        raise StudyError(f"{name}: expected 3 finite numbers, found {value!r}")
    return vector


def check_rising(name, value):
    """Numbers from 0 on, each above the one before, as a tuple."""
    try:
        numbers = tuple(float(each) for each in value)
    except (TypeError, ValueError):
        numbers = (math.nan,)
    if not all(map(math.isfinite, numbers)) or any(b <= a for a, b in zip((-math.inf, *numbers), numbers)) or min(numbers, default=0) < 0:
        raise StudyError(f"{name}: expected rising numbers from 0 on, found {value!r}")
    return numbers


def weights_in(nodes, tetrahedra, point):
    """Barycentric weights of a point in each of n tetrahedra, n x 4."""
    corners = nodes[tetrahedra]  # n x 4 x 3
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    shares = np.linalg.solve(edges, (point - corners[:, 0])[..., None])[..., 0] if len(corners) else np.zeros((0, 3))
    return np.column_stack([1 - shares.sum(axis=1), shares])


def any_inside(nodes, tetrahedra, points):
    """Whether a tetrahedron holds one of the points."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    return any(np.all(point >= low) and np.all(point <= high) and weights_in(nodes, tetrahedra, point).min(axis=1).max() >= 0
               for point in points)


def digest(*values):
    """A hash (hex) that changes when a value does: numbers, texts, arrays, maps, objects by their fields and
    their classes' members, functions by their code, defaults and what they enclose, but not by the globals that they use."""
    hasher = hashlib.sha256()
    for piece in pieces(values, ()):
        hasher.update(len(piece).to_bytes(8, "little"))
        hasher.update(piece)
    return hasher.hexdigest()


def pieces(value, inside):
    """As bytes, one after the other. `inside`: the objects that it is in, which it may refer to."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes, range)):
        yield f"{type(value).__name__} {value!r}".encode()
        return
    if any(value is each for each in inside):
        yield b"again"
        return
    inside = (*inside, value)
    if isinstance(value, np.ndarray) and value.dtype.hasobject:
        yield from pieces(value.tolist(), inside)
        return
    if isinstance(value, (np.ndarray, np.generic)):
        yield f"array {value.dtype} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
        return
    yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
    for part in parts(value):
        yield from pieces(part, inside)


def parts(value):
    if isinstance(value, dict):
        return [part for pair in value.items() for part in pair]
    if isinstance(value, (list, tuple)):
        return [len(value), *value]
    if isinstance(value, (set, frozenset)):
        return sorted(map(digest, value))
    if isinstance(value, types.FunctionType):
        enclosed = [cell.cell_contents for cell in value.__closure__ or () if holds(cell)]
        return [value.__qualname__, value.__code__, value.__defaults__, value.__kwdefaults__, enclosed]
    if isinstance(value, types.CodeType):
        return [value.co_code, value.co_names, value.co_consts]
    if isinstance(value, types.MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, functools.partial):
        return [value.func, value.args, value.keywords]
    if isinstance(value, type):
        return [value.__module__, value.__qualname__, *([] if is_of_a_library(value) else [members(value), value.__bases__])]
    if isinstance(value, (staticmethod, classmethod)):
        return [value.__func__]
    if isinstance(value, property):
        return [value.fget, value.fset]
    if isinstance(value, (types.ModuleType, types.BuiltinFunctionType)):
        return [getattr(value, "__qualname__", value.__name__)]
    if dataclasses.is_dataclass(value):
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        return [type(value), {**getattr(value, "__dict__", {}), **fields}]
    return [type(value), state_of(value)]


def state_of(value):
    """Of any object, by how it is copied or pickled. Raises StudyError where nothing tells it from others."""
    if hasattr(value, "__dict__") and not hasattr(type(value), "__slots__"):
        return value.__dict__
    try:
        _, arguments, *rest = value.__reduce_ex__(4)
        return [[each for each in arguments if each is not type(value)], rest[0] if rest else None]
    except (TypeError, ValueError):
        pass
    if " at 0x" in repr(value):
        raise StudyError(f"a motion, output or prepare holds {value!r}, of which nothing says whether it has changed; hold plain "
                         "values, or make it in a function")
    return repr(value)


def members(of):
    """What a class defines itself: methods, and attributes that are values."""
    wanted = (types.FunctionType, staticmethod, classmethod, property)
    return {name: each for name, each in vars(of).items() if isinstance(each, wanted) or
            (not name.startswith("__") and not inspect.isdatadescriptor(each) and not inspect.isgetsetdescriptor(each))}


def is_of_a_library(of):
    """Whether a class belongs to Python or what is installed beside it: its version is taken to stay."""
    path = getattr(sys.modules.get(of.__module__), "__file__", None)
    if path is None:  # built in, or of the program itself
        return of.__module__ in sys.builtin_module_names
    return any(folder in path for folder in ("/site-packages/", "/dist-packages/", os.path.dirname(os.__file__) + os.sep))


def holds(cell):
    try:
        return cell.cell_contents is not cell  # raises where it is empty
    except ValueError:
        return False
