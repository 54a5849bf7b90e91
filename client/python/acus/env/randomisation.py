# SPDX-License-Identifier: MIT
"""Scenes whose parameters are drawn anew for each episode."""

import math


class Uniform:
    def __init__(self, low, high):
        self.low, self.high = low, high

    def __call__(self, random):
        return float(random.uniform(self.low, self.high))


class LogUniform:
    """Of a parameter that may be this many times larger or smaller, such as a stiffness."""

    def __init__(self, low, high):
        self.low, self.high = low, high

    def __call__(self, random):
        return math.exp(random.uniform(math.log(self.low), math.log(self.high)))


def draw(parameters, random):
    """{place: value} of {place: (low, high), a distribution, or any function of a numpy Generator}."""
    values = {}
    for place, distribution in parameters.items():
        distribution = Uniform(*distribution) if isinstance(distribution, (tuple, list)) else distribution
        values[place] = distribution(random)
    return values
