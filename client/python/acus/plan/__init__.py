# SPDX-License-Identifier: MIT
"""Where a needle should go in: docs/plans.md. The package itself can be called, acus.plan(...)."""

import sys
import types

from .cloud import Cloud
from .implant import Implant, Implantation, implant
from .planner import plan
from .plans import Plan, Plans
from .steering import Belief, Course, Steering


class _Callable(types.ModuleType):
    def __call__(self, *arguments, **settings):
        return plan(*arguments, **settings)


sys.modules[__name__].__class__ = _Callable
