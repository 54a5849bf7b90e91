# SPDX-License-Identifier: MIT
"""What a parameter is drawn from: in environments anew for each episode, in studies for each case.

A distribution has its quantile function, `at(u)` for u in [0, 1), and can be called with a numpy Generator.
"""

import math
from statistics import NormalDist

LEAST = 2.0**-54  # from where to where u goes for distributions without bounds


class Distribution:
    def at(self, u):
        """The value below which a share u of all values lies."""
        raise NotImplementedError

    def __call__(self, random):
        return self.at(random.uniform())

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(map(repr, vars(self).values()))})"


class Uniform(Distribution):
    def __init__(self, low, high):
        self.low, self.high = in_order(float(low), float(high))

    def at(self, u):
        return float(self.low + (self.high - self.low) * u)


class LogUniform(Distribution):
    """Of a parameter that may be this many times larger or smaller, such as a stiffness."""

    def __init__(self, low, high):
        self.low, self.high = in_order(float(low), float(high))
        if not self.low > 0:
            raise ValueError(f"LogUniform: expected bounds above 0, found {low}")

    def at(self, u):
        low, high = math.log(self.low), math.log(self.high)
        return math.exp(low + (high - low) * u)


class Normal(Distribution):
    """With bounds, values beyond them are drawn again."""

    def __init__(self, mean, deviation, low=-math.inf, high=math.inf):
        self.mean, self.deviation = float(mean), float(deviation)
        self.low, self.high = in_order(float(low), float(high))
        if not (math.isfinite(self.mean) and 0 < self.deviation < math.inf):
            raise ValueError(f"Normal: expected a finite mean and a deviation above 0, found {mean}, {deviation}")
        if not self._share(self.high) - self._share(self.low) > 1e-9:
            raise ValueError("Normal: expected bounds that some of the values keep to")

    def at(self, u):
        low, high = self._share(self.low), self._share(self.high)
        share = min(max(low + (high - low) * u, LEAST), 1 - LEAST)
        return min(max(NormalDist(self.mean, self.deviation).inv_cdf(share), self.low), self.high)

    def _share(self, value):
        return NormalDist(self.mean, self.deviation).cdf(value) if math.isfinite(value) else float(value > 0)


class Choice(Distribution):
    """One of a few values, each as likely."""

    def __init__(self, *values):
        if not values:
            raise ValueError("Choice: expected at least one value")
        self.values = values

    def at(self, u):
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]


def in_order(low, high):
    if not low <= high:
        raise ValueError(f"expected a range from low to high, found {low} to {high}")
    return low, high


def distribution_of(given):
    """Of (low, high), a Distribution, or one of scipy.stats with its parameters."""
    if isinstance(given, (tuple, list)):
        if len(given) != 2:
            raise ValueError(f"expected a range (low, high), found {given!r}")
        return Uniform(*given)
    return given


def draw(parameters, random):
    """{place: value} of {place: (low, high), a distribution, or any function of a numpy Generator}."""
    return {place: distribution_of(given)(random) for place, given in parameters.items()}
