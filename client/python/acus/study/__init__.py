# SPDX-License-Identifier: MIT
"""Many runs of one scene, on all processors: docs/studies.md says how."""

from ..distributions import Choice, LogUniform, Normal, Uniform
from .designs import Design, grid, latin_hypercube, sobol, table
from .motions import Insertion
from .outputs import OUTPUTS, Distance, Result
from .sensitivity import saltelli, sobol_indices
from .study import Study
from .trajectory import Trajectory
from .world import World
