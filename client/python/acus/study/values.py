# SPDX-License-Identifier: MIT
"""Checks of what users give, and hashes of it."""

import dataclasses
import functools
import hashlib
import math
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


def digest(*values):
    """A hash (hex) that changes when a value does: numbers, texts, arrays, maps, objects by their fields, functions by
    their code, defaults and what they enclose, but not by the globals that they use."""
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
        functions = {name: each for name, each in vars(value).items() if isinstance(each, types.FunctionType)}
        return [value.__module__, value.__qualname__, functions]
    if isinstance(value, (types.ModuleType, types.BuiltinFunctionType)):
        return [getattr(value, "__qualname__", value.__name__)]
    if dataclasses.is_dataclass(value):
        return [type(value), {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}]
    return [type(value), getattr(value, "__dict__", None) or repr(value)]


def holds(cell):
    try:
        return cell.cell_contents is not cell  # raises where it is empty
    except ValueError:
        return False
