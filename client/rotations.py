# SPDX-License-Identifier: MIT
"""Vectors as tuples and rotations as unit quaternions (w, x, y, z), with the standard library alone."""

import math


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def subtract(a, b):
    return tuple(x - y for x, y in zip(a, b))


def normalised(v):
    length = math.sqrt(dot(v, v))
    if length == 0:
        raise ValueError("a direction must not be zero")
    return tuple(x / length for x in v)


def multiply(p, q):
    """Hamilton product of quaternions (w, x, y, z)."""
    vector = [p[0] * b + q[0] * a + c for a, b, c in zip(p[1:], q[1:], cross(p[1:], q[1:]))]
    return (p[0] * q[0] - dot(p[1:], q[1:]), *vector)


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q, v):
    return multiply(multiply(q, (0.0, *v)), conjugate(q))[1:]


def shortest_rotation(a, b):
    """The rotation about a x b that turns the unit vector a to the unit vector b."""
    if dot(a, b) < -1 + 1e-12:  # any axis across a will do
        across = (1.0, 0.0, 0.0) if abs(a[0]) < 0.9 else (0.0, 1.0, 0.0)
        return (0.0, *normalised(cross(a, across)))
    return normalised((1 + dot(a, b), *cross(a, b)))


def frame_quaternion(axis, side):
    """w x y z of the frame whose +x is `axis` and whose +y is as near to `side` as that allows."""
    x = normalised(axis)
    z = normalised(cross(x, side))
    y = cross(z, x)
    m = ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]))
    # The largest of the four candidates loses no digits.
    candidates = (
        1 + m[0][0] + m[1][1] + m[2][2],
        1 + m[0][0] - m[1][1] - m[2][2],
        1 - m[0][0] + m[1][1] - m[2][2],
        1 - m[0][0] - m[1][1] + m[2][2],
    )
    best = max(range(4), key=lambda i: candidates[i])
    s = 2 * math.sqrt(candidates[best])
    if best == 0:
        return (s / 4, (m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s)
    if best == 1:
        return ((m[2][1] - m[1][2]) / s, s / 4, (m[0][1] + m[1][0]) / s, (m[0][2] + m[2][0]) / s)
    if best == 2:
        return ((m[0][2] - m[2][0]) / s, (m[0][1] + m[1][0]) / s, s / 4, (m[1][2] + m[2][1]) / s)
    return ((m[1][0] - m[0][1]) / s, (m[0][2] + m[2][0]) / s, (m[1][2] + m[2][1]) / s, s / 4)
