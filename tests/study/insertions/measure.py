# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs an insertion, and measures what anyone takes for granted of it."""

import dataclasses

import numpy as np

import acus
from acus.apps.jumps import sizes
from acus.drawn import Dents
from acus.plan.tissue import boundary_of
from acus.rotation import axis_of
from acus.tissue_points import TissuePoints

SHAFT = 100  # places of a needle that are looked at before it begins
LOOK = 5  # ticks between two looks at the drawn skin
BEFORE, AFTER = 3, 12  # ticks around a step of the force in which its event may lie
STEP, SHARE = 0.05, 0.2  # N, and of the largest force of the run: a step is more


@dataclasses.dataclass
class Course:
    """What a run tells, tick by tick."""
    forces: np.ndarray  # N, n x 3, base
    unheld: np.ndarray  # m
    flags: np.ndarray
    events: list  # (tick, kind, N)
    under_skin: np.ndarray  # m, tip below the drawn skin; nan where it is not looked at
    work: np.ndarray  # J, of the hand so far


def run(insertion, looks=True):
    """The Course; `looks`: with the tip under the drawn skin. Raises SceneError where the needle begins in the tissue."""
    model = acus.engine.load(insertion.scene)
    state, triangles = model.start(), boundary_of(model.tetrahedra)
    ends = np.array(state.needle_positions("n"))[[0, -1]]
    if not TissuePoints(model, np.linspace(*ends, SHAFT)).outside.all():
        raise acus.SceneError("expected the needle outside the tissue, found its shaft inside it")
    base, work, told, events = insertion.base.copy(), 0.0, [], []
    for tick, move in enumerate(insertion.moves):
        base = base + move
        report = acus.engine.step(model, state, {"n": (tuple(base), tuple(insertion.orientation), 0.0)})
        needle = report["n"]
        force = np.array(needle.base_force)
        work -= float(force @ move)
        under = np.nan
        if looks and tick % LOOK == 0 and needle.phase == "contact":
            under = _under_skin(state, triangles, np.array(needle.tip_position))
        events += [(tick, event.kind, float(event.force)) for event in report.events]
        told.append((force, needle.unheld, report.flags, under, work))
    forces, unheld, flags, under_skin, worked = map(np.array, zip(*told))
    return Course(forces, unheld, flags, events, under_skin, worked)


def _under_skin(state, triangles, tip):
    """m, how deep a point lies below the skin as it is drawn, 0 above it."""
    nodes, pieces = Dents(*state.dents).surface(np.array(state.tissue_positions), triangles)
    a, b, c = (nodes[pieces[:, each]] for each in range(3))
    nearest = nearest_on_triangles(tip, a, b, c)
    ways = tip - nearest
    distances = np.linalg.norm(ways, axis=1)
    normals = np.cross(b - a, c - a)
    close = distances <= distances.min() + 1e-7  # an edge or a corner belongs to several
    return float(distances.min()) if (ways[close] * normals[close]).sum() < 0 else 0.0


def nearest_on_triangles(p, a, b, c):
    """The nearest point of each triangle to p: inside it, or on one of its edges."""
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    area = (normal**2).sum(axis=1)
    v = (np.cross(p - a, ac) * normal).sum(axis=1) / area
    w = (np.cross(ab, p - a) * normal).sum(axis=1) / area
    inside = (v >= 0) & (w >= 0) & (v + w <= 1)
    best = a + v[:, None] * ab + w[:, None] * ac
    distance = np.where(inside, np.linalg.norm(p - best, axis=1), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        way = end - start
        along = np.clip(((p - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0, 1)
        on_edge = start + along[:, None] * way
        away = np.linalg.norm(p - on_edge, axis=1)
        best = np.where((away < distance)[:, None], on_edge, best)
        distance = np.minimum(distance, away)
    return best


@dataclasses.dataclass
class Step:
    """A step of the base force that no event just before explains."""
    tick: int
    size: float  # N
    follows: str  # the event within AFTER ticks, or ""
    flags: list


def jumps_of(forces):
    """N, of each tick: acus-plot's jump, and not more than the change of force differs from that of the tick before or after. What rises
    steadily, however fast, or begins or ends to, does not jump."""
    differs = np.linalg.norm(np.diff(forces, 2, axis=0), axis=1)
    beside = np.minimum(np.append(differs, np.inf), np.insert(differs, 0, np.inf))
    return np.minimum(sizes(forces), np.insert(beside, 0, 0))


def steps_of(course):
    """The largest Step of each stretch of ticks, the largest first."""
    jumps = jumps_of(course.forces)
    least = max(STEP, SHARE * np.linalg.norm(course.forces, axis=1).max())
    times = np.array([tick for tick, _, _ in course.events] or [-100])
    found, taken = [], []
    for tick in map(int, np.argsort(-jumps)):
        if jumps[tick] < least:
            break
        if np.any((times <= tick) & (times >= tick - BEFORE)) or any(abs(tick - each) <= AFTER for each in taken):
            continue
        taken.append(tick)
        later = [kind for at, kind, _ in course.events if tick < at <= tick + AFTER]
        found.append(Step(tick, float(jumps[tick]), later[0] if later else "", acus.flag_names(int(np.bitwise_or.reduce(course.flags[max(0, tick - 3):tick + 1])))))
    return found


def figures(insertion, course):
    """{name: number or word} of a run."""
    steps = steps_of(course)
    flags = acus.flag_names(int(np.bitwise_or.reduce(course.flags)))
    direction = axis_of(insertion.orientation)
    drawn = [move @ direction < -0.1 * np.linalg.norm(move) for move in insertion.moves]
    pulled = np.insert(course.forces @ direction, 0, 0.0)  # N, before each tick
    punctures = [(tick, force) for tick, kind, force in course.events if kind == "puncture"]
    return {"number": insertion.number, **insertion.about, "ticks": len(insertion.moves), "largest": float(np.linalg.norm(course.forces, axis=1).max()),
            "finite": bool(np.isfinite(course.forces).all()), "steps": len(steps), "step": steps[0].size if steps else 0.0,
            "step_tick": steps[0].tick if steps else -1, "step_follows": steps[0].follows if steps else "",
            "step_flags": " ".join(steps[0].flags) if steps else "", "unheld": float(course.unheld.max()),
            "under_skin": float(np.nanmax(course.under_skin)) if np.isfinite(course.under_skin).any() else 0.0,
            "punctures": len(punctures), "punctures_drawn": sum(bool(drawn[tick] or pulled[tick] > 0.01 * force) for tick, force in punctures),
            "work": float(course.work.min()), "flags": " ".join(flags), "end": float(np.linalg.norm(course.forces[-1]))}
