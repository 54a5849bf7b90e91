# SPDX-License-Identifier: MIT
"""Checks of arguments. All raise PlanError, which begins with the argument's name."""

import numpy as np

from ..errors import AcusError, PlanError
from ..study.values import check_number


def named(name, check):
    """What check() returns; its error begins with the argument's name."""
    try:
        return check()
    except AcusError as error:
        text = str(error)
        raise PlanError(text if text.startswith(name) else f"{name}: {text}") from None


def check_range(name, value, least, most):
    named(name, lambda: check_number(name, value))
    if not least <= value <= most:
        raise PlanError(f"{name}: expected {least:g} to {most:g}, found {value!r}")


def check_whole(name, value, least):
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value < least:
        raise PlanError(f"{name}: expected a whole number, at least {least}, found {value!r}")


def check_positive(name, value):
    named(name, lambda: check_number(name, value))
    if value <= 0:
        raise PlanError(f"{name}: expected a number above 0, found {value!r}")
