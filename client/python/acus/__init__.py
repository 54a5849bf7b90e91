# SPDX-License-Identifier: MIT
"""Needles in soft tissue, simulated by acus-server or in this process: docs/python.md says how this package is used."""

from . import engine, fit, plan, study
from .client import Client
from .drawn import Dents
from .errors import (AcusError, ClientError, EnvError, FitError, KeyFileError, KeysRefused, PlanError, ProgramNotFound, ProtocolMismatch, Refused,
                     RunError, SceneError, ServerFailed, StudyError, Vanished)
from .keys import Keys
from .messages import (DescribeReply, Done, Event, Force, Guide, Haptics, HashReply, HelloReply, Needle,
                       NeedleShape, SnapshotReply, States, Stats, TissueShape, flag_names)
from .programs import find_scene, find_server
from .run import Run, Track
from .scene import Scene
from .server import Server
from .shapes import Shapes
from .study import Insertion, Study

__version__ = "0.1.0"
