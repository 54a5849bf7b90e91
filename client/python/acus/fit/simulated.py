# SPDX-License-Identifier: MIT
"""Curves that a scene gives."""

import math

import numpy as np

from .. import engine
from ..errors import FitError
from ..study.case import carried_out
from ..study.motions import policy_of
from .curve import Curve
from .measurement import Measurement


def simulated_curve(scene, motion, over, of):
    """The Curve of a motion in a Scene: as a Measurement has `over` and `of`. Raises AcusError."""
    try:
        return curve_of(carried_out(motion, engine.load(scene)), over, of)
    except (ValueError, KeyError) as error:  # of the engine, for what cannot stand where it should
        raise FitError(f"{scene.fields.get('name', 'scene')}: {error}") from None


def curve_of(result, over, of):
    """The Curve of a run."""
    track = result.track
    if of == "force":
        y = track.axial_resistance
    else:
        way = track.tip_position - result.needle.base_position
        y = np.linalg.norm(way - np.outer(way @ result.needle.axis, result.needle.axis), axis=1)
    if over == "time":
        return Curve(track.time, y)
    travel = (track.base_position - result.needle.base_position) @ result.needle.axis
    further = np.flatnonzero(np.diff(np.maximum.accumulate(travel), prepend=-math.inf) > 0)  # in than ever before
    return Curve(travel[further], y[further])


def simulated(scene, motion, *, over="travel", of="force", noise=0.0, points=300, seed=0, shift=0.0, **settings):
    """A Measurement that a Scene gives, with normal noise of this deviation (N or m): it shows what a fit would make of an
    experiment before anybody makes it. `settings`: of Measurement."""
    curve = simulated_curve(scene, policy_of(motion), over, of)
    x = np.linspace(curve.x[0], curve.x[-1], points)
    y = curve.at(x) + np.random.default_rng(seed).normal(0, 1, points) * noise
    return Measurement(x + shift, y, over, of, motion, **settings)
