# SPDX-License-Identifier: MIT
"""Functions and objects as bytes for other processes. With cloudpickle also those of the program itself, of a notebook or
within functions; without it only those of modules that can be imported."""

import pickle

from ..errors import StudyError

try:
    import cloudpickle as pickler
except ImportError:
    pickler = pickle


def dumps(value):
    """Raises StudyError."""
    try:
        return pickler.dumps(value)
    except Exception as error:  # pylint: disable=broad-except  # pickling raises what it likes
        remedy = "" if pickler is not pickle else "; install cloudpickle (apt install python3-cloudpickle)"
        raise StudyError(f"a motion, output or prepare cannot be handed to workers: {error}{remedy}") from None


def loads(data):
    return pickle.loads(data)
