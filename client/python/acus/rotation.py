# SPDX-License-Identifier: MIT
"""Orientations as unit quaternions (w, x, y, z) in numpy arrays; the last axis holds the four components."""

import math

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
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * unit(axis)])


def unit(vector):
    """Of the same direction, of length 1."""
    vector = np.asarray(vector, dtype=float)
    length = np.linalg.norm(vector)
    if length == 0:
        raise ValueError("a direction must not be zero")
    return vector / length


def shortest_rotation(a, b):
    """The rotation about a x b that turns the direction a to the direction b, both of any length."""
    a, b = unit(a), unit(b)
    if a @ b < -1 + 1e-12:  # any axis across a will do
        across = (1.0, 0.0, 0.0) if abs(a[0]) < 0.9 else (0.0, 1.0, 0.0)
        return np.array([0.0, *unit(np.cross(a, across))])
    return unit([1 + a @ b, *np.cross(a, b)])


def slerp(p, q, share):
    """The rotation a share of the way from p to q, along the shortest arc."""
    turn = multiply(conjugate(p), q)
    turn = turn if turn[0] >= 0 else -turn
    length = np.linalg.norm(turn[1:])
    if length < 1e-12:
        return np.array(p)
    angle = 2 * math.atan2(length, turn[0])
    return unit(multiply(p, rotation_about(turn[1:], share * angle)))


def orientation_along(direction):
    """The shortest rotation that turns +x along a direction of any length: the orientation of a needle."""
    return shortest_rotation((1.0, 0.0, 0.0), direction)


def orientation_of(axis, side):
    """Of the frame whose +x is along `axis` and whose +y is as near to `side` as that allows."""
    x = unit(axis)
    z = unit(np.cross(x, side))
    m = np.stack([x, np.cross(z, x), z], axis=1)
    diagonal = np.diag(m)
    squares = np.array([1 + diagonal.sum(), *(1 + 2 * diagonal - diagonal.sum())])  # 4 w^2, 4 x^2, 4 y^2, 4 z^2
    first = int(np.argmax(squares))  # the largest loses no digits
    products = np.array([  # 4 q_i q_j
        [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]],
    ])
    return products[first] / (2 * np.sqrt(squares[first]))
