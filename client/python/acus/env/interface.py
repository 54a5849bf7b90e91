# SPDX-License-Identifier: MIT
"""Gymnasium's Env and spaces where that package is installed; else what this one needs of them, with the same names."""

import numpy as np

try:
    from gymnasium import Env
    from gymnasium.spaces import Box, Discrete
except ImportError:
    class Env:
        """np_random is drawn from; reset(seed=...) begins its series anew."""

        metadata = {"render_modes": []}
        render_mode = None
        np_random = None

        def reset(self, *, seed=None, options=None):  # pylint: disable=unused-argument
            if seed is not None or self.np_random is None:
                self.np_random = np.random.default_rng(seed)

        @property
        def unwrapped(self):
            return self

        def close(self):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            self.close()

    class Space:
        """What an action or an observation may be."""

        def __init__(self, shape, dtype, seed=None):
            self.shape = shape
            self.dtype = np.dtype(dtype)
            self.seed(seed)

        def seed(self, seed=None):
            self.np_random = np.random.default_rng(seed)

        def __contains__(self, value):
            return self.contains(value)

    class Box(Space):
        """Numbers between `low` and `high`, each of them or all."""

        def __init__(self, low, high, shape=None, dtype=np.float32, seed=None):
            shape = np.shape(low) if shape is None else tuple(shape)
            super().__init__(shape, dtype, seed)
            self.low, self.high = (np.full(shape, bound, dtype) for bound in (low, high))

        def sample(self):
            """Uniform within the bounds, normal where there are none."""
            bounded = np.isfinite(self.low) & np.isfinite(self.high)
            low, high = np.where(bounded, self.low, 0), np.where(bounded, self.high, 1)
            uniform = self.np_random.uniform(low, high)
            return np.where(bounded, uniform, self.np_random.normal(size=self.shape)).astype(self.dtype)

        def contains(self, value):
            value = np.asarray(value)
            return bool(value.shape == self.shape and np.all(value >= self.low) and np.all(value <= self.high))

    class Discrete(Space):
        """0 to n - 1."""

        def __init__(self, n, seed=None):
            self.n = n
            super().__init__((), np.int64, seed)

        def sample(self):
            return self.np_random.integers(self.n)

        def contains(self, value):
            return np.shape(value) == () and int(value) == value and 0 <= value < self.n
