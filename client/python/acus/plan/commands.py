# SPDX-License-Identifier: MIT
"""What a motion commands, for acus-server and acus-replay."""

import os

from .. import own_files
from ..errors import PlanError
from ..scene import plain
from ..study.case import Models
from ..study.world import World, with_guides

COLUMNS = ("t", "needle", "x", "y", "z", "qw", "qx", "qy", "qz", "spin")
REST = 0.5  # s at the end of a trajectory, in which a base that lags arrives


class Logged(World):
    """Notes the commands of each tick: [(tick, {name: pose})]."""

    def __init__(self, model, bodies=None):
        super().__init__(model, bodies=bodies)
        self.log = []

    def step(self, ticks=1):
        if self._commands:
            self.log.append((self.state.tick, dict(self._commands)))
        return super().step(ticks)


def placed_scene(scene, motion):
    """A copy of the scene with needles and guides where the motion begins."""
    scene = scene.copy()
    model = Models().load(scene)
    bodies = with_guides(model, motion.bodies(model))
    places = [*((each.name, f"needles[{number}].base") for number, each in enumerate(model.needles)),
              *((each.name, f"guides[{number}].pose") for number, each in enumerate(model.guides))]
    for name, place in places:
        if name in bodies:
            scene[f"{place}.position"], scene[f"{place}.orientation"] = map(plain, bodies[name])
    return scene


def write_motion(path, scene, motion):
    """`path`.yaml, the scene with the needles where the motion begins, and `path`.csv, its trajectory. Both paths. Raises
    PlanError."""
    path = os.fspath(path).removesuffix(".yaml").removesuffix(".csv")
    scene_file, motion_file = f"{path}.yaml", f"{path}.csv"
    for each in (scene_file, motion_file):
        own_files.check(each, own_files.is_sealed, PlanError)
    model = Models().load(scene)
    world = Logged(model, motion.bodies(model))
    motion(world)
    own_files.write(scene_file, own_files.sealed(placed_scene(scene, motion).text()), own_files.is_sealed, PlanError)
    table = own_files.table_of(COLUMNS, (
        [repr(tick * world.time_step), name, *map(repr, [*plain(position), *plain(orientation), float(spin)])]
        for tick, name, position, orientation, spin in rows_of(world)))
    own_files.write(motion_file, own_files.sealed(table.decode()), own_files.is_sealed, PlanError)
    return scene_file, motion_file


def rows_of(world):
    """(tick, name, position, orientation, spin), by time; what rests has a row before it goes on: between rows poses run
    straight."""
    last = {each.name: (0, each.base_position, each.base_orientation, 0.0) for each in world.needles}
    rows = [(0, name, *pose[1:]) for name, pose in last.items()]
    for tick, commands in world.log:
        for name, (position, orientation, *spin) in commands.items():
            before, *pose = last.get(name, (tick, position, orientation, 0.0))
            if tick > before:
                rows.append((tick, name, *pose))
            last[name] = (tick + 1, position, orientation, float(spin[0]) if spin else pose[2])
            rows.append((tick + 1, name, *last[name][1:]))
    end = max(world.state.tick, *(tick for tick, *_ in rows)) + world.ticks_of(REST)
    return sorted([*rows, *((end, name, *pose[1:]) for name, pose in last.items())], key=lambda row: row[0])
