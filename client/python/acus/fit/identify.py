# SPDX-License-Identifier: MIT
"""How well a fit knows its parameters, from the slopes of the misfits at the answer (J, points x parameters).

The answer is q; near it the misfits are r + J (q' - q), and (JᵀJ)⁻¹ |r|²/(n - p) is the covariance of p parameters, n being the
number of independent points (the linear theory of nonlinear least squares: Bates, Watts 1988, "Nonlinear Regression
Analysis and Its Applications", ch. 2). Misfits of neighbouring points are alike where a model is not quite the
experiment: with rho = sum r_i r_i+1 / sum r_i², N points tell as much as N (1 - rho)/(1 + rho). At the end of a
parameter's interval, the others following it, |r|² has risen by t² |r|²/(n - p), t of Student's distribution; where runs
show that it has not, the interval goes on to where it has.
"""

import dataclasses

import numpy as np

CONFIDENCE = 0.95
WIDE = 0.5  # share of a parameter's range that an interval may cover
TIED = 0.95  # correlation, from which two parameters are named together
AT_LIMIT = 1e-3  # share of the range
LEAST = 1e-8  # of a singular value, as a share of the largest
FEWEST = 5  # independent points


@dataclasses.dataclass
class Identified:
    """In units of the parameters' ranges, 0 to 1."""

    deviation: np.ndarray  # of each parameter
    half_width: np.ndarray  # of its interval
    correlation: np.ndarray  # parameters x parameters
    rise: float  # of |r|², at the ends of intervals
    independent: float  # points

    def towards(self, k):
        """Where the parameters are best while the k-th is 1 above the answer."""
        return self.correlation[k] * self.deviation / self.deviation[k] if self.deviation[k] > 0 else np.eye(len(self.deviation))[k]


def identify(residuals, slopes, independent):
    """`residuals` (points,) and `slopes` (points, parameters) of the fitted points there, each by the
    root of its weight; `independent`: how many points they are as good as."""
    from scipy.stats import t as student  # pylint: disable=import-outside-toplevel  # takes a second
    parameters = slopes.shape[1]
    independent = max(independent, FEWEST)
    freedom = max(1.0, independent - parameters)
    _, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    sizes = np.maximum(sizes, LEAST * max(sizes.max(initial=0), LEAST))
    covariance = (directions.T / sizes**2) @ directions * (residuals @ residuals) / freedom
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation) if np.all(deviation > 0) else np.eye(parameters)
    factor = student.ppf(0.5 + CONFIDENCE / 2, freedom)
    return Identified(deviation, deviation * factor, correlation, factor**2 * (residuals @ residuals) / freedom, float(independent))


def independent_points(share, misfits):
    """How many points these are as good as, where all in one `share` of the range of x (a number of each) count as one."""
    filled = np.bincount(share)
    means = np.bincount(share, weights=misfits)[filled > 0] / filled[filled > 0]
    power = means @ means
    rho = float(np.clip(means[1:] @ means[:-1] / power, 0, 0.999)) if power > 0 else 0.0
    return len(means) * (1 - rho) / (1 + rho)


def doubts(names, place, low, high, correlation, slopes, residuals):
    """{name: why it cannot be identified} of the parameters whose intervals go from `low` to `high`."""
    found = [doubt(names, k, place, high[k] - low[k], correlation, slopes, residuals) for k in range(len(names))]
    return {name: why for name, why in zip(names, found) if why}


def doubt(names, k, place, width, correlation, slopes, residuals):
    if np.linalg.norm(slopes[:, k]) <= 0.1 * np.linalg.norm(residuals) and width > WIDE:
        return "the data hardly depend on it"
    if width > WIDE:
        others = np.abs(np.delete(correlation[k], k))
        if len(others) and others.max() > TIED:
            partner = [name for i, name in enumerate(names) if i != k][int(others.argmax())]
            return f"the data tell it only together with {partner} (correlation {correlation[k][names.index(partner)]:+.3f})"
        return f"its interval covers {width:.0%} of its range"
    if min(place[k], 1 - place[k]) < AT_LIMIT:
        return f"it is at the {'lower' if place[k] < 0.5 else 'upper'} limit of its range"
    return ""
