# SPDX-License-Identifier: MIT
"""Orientations as unit quaternions (w, x, y, z) in numpy arrays; the last axis holds the four components."""

import numpy as np


def axis_of(quaternions):
    """Where each orientation turns +x: the direction from base to tip. (..., 4) to (..., 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, dtype=float), -1, 0)
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)


def multiply(p, q):
    """Hamilton's product: q first, then p."""
    p, q = np.asarray(p, dtype=float), np.asarray(q, dtype=float)
    scalar = p[..., 0] * q[..., 0] - np.sum(p[..., 1:] * q[..., 1:], axis=-1)
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([scalar[..., None], vector], axis=-1)


def conjugate(q):
    return np.asarray(q, dtype=float) * [1, -1, -1, -1]


def rotate(q, v):
    """Vectors of the frame into the world: v_world = q v q*."""
    q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
    turned = 2 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * turned + np.cross(q[..., 1:], turned)


def rotation_about(axis, angle):
    """By an angle (rad) about an axis of any length, which must not be zero."""
    axis = np.asarray(axis, dtype=float)
    length = np.linalg.norm(axis)
    if length == 0:
        raise ValueError("an axis must not be zero")
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) / length * axis])


def orientation_along(direction):
    """The shortest rotation that turns +x along a direction of any length: the orientation of a needle."""
    direction = np.asarray(direction, dtype=float)
    length = np.linalg.norm(direction)
    if length == 0:
        raise ValueError("a direction must not be zero")
    x, y, z = direction / length
    if x < -1 + 1e-12:
        return np.array([0.0, 0.0, 0.0, 1.0])
    quaternion = np.array([1 + x, 0.0, -z, y])  # (1 + a . b, a x b) with a = +x
    return quaternion / np.linalg.norm(quaternion)
