# SPDX-License-Identifier: MIT
"""Parameters of a scene from measured curves: docs/fitting.md."""

from .fit import Fit
from .fitted import Fitted, Prediction
from .measurement import Measurement, read_measurement
from .simulated import simulated

__all__ = ["Fit", "Fitted", "Measurement", "Prediction", "read_measurement", "simulated"]
