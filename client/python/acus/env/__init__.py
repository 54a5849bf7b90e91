# SPDX-License-Identifier: MIT
"""Environments for learning to steer needles: docs/python.md says what each task asks for."""

from .needle_env import POLICIES, TASKS, NeedleEnv
from ..distributions import LogUniform, Uniform
from .task import Outcome, Task
from .vector_env import VectorEnv
from .world import World
