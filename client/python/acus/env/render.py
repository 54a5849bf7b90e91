# SPDX-License-Identifier: MIT
"""A picture of a world on the engine: a cut through the tissue along a needle, as acus-picture draws it. Needs matplotlib and
pillow."""

import numpy as np

from ..drawn import Dents
from ..errors import EnvError
from ..rotation import rotate

SIZE = (6.4, 4.8)  # inches
DOTS = 100  # per inch
TARGET_STYLE = {"marker": "x", "color": "#cc0000", "markersize": 10, "markeredgewidth": 2.5, "zorder": 7}


class Frame:
    """What there is now, with the names of acus.shapes.Frame."""

    def __init__(self, model, state, guides=()):
        self.tissue, self.paths, self.dents = state.tissue_positions, state.paths, Dents(*state.dents)
        self.needles = {each.name: (state.needle_positions(each.name), state.needle_orientations(each.name)) for each in model.needles}
        self.guides = {each.name: (each.position, each.orientation) for each in guides}
        self.tetrahedra, self.region_of = model.tetrahedra, model.tetrahedron_regions
        self.frame = self  # it is its own moment, too


def picture(model, state, needle, target=None, guides=()):
    """Red, green, blue of each pixel (480, 640, 3), from 0 to 255. The plane holds the needle's axis as it was after loading,
    and the target (m, world), which is marked."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # pylint: disable=import-outside-toplevel  # takes a second
        from matplotlib.figure import Figure  # pylint: disable=import-outside-toplevel
        from ..drawing import cuts  # pylint: disable=import-outside-toplevel
    except ImportError:
        raise EnvError("render: it needs matplotlib and pillow (apt install python3-matplotlib python3-pil)") from None
    frame, view = Frame(model, state, guides), cuts.View(needle.base_position, normal_of(needle, target), needle.axis)
    figure = Figure(SIZE, DOTS, layout="constrained")
    canvas, axes = FigureCanvasAgg(figure), figure.subplots()
    cuts.draw_view(axes, view, frame, frame, (), needle.name)
    if target is not None:
        axes.plot(*view.flat(np.asarray(target, dtype=float)), **TARGET_STYLE)
    low, high = cuts.limits_of(view, [frame])
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel(view.label(view.right))
    axes.set_ylabel(view.label(view.up))
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3]


def normal_of(needle, target):
    """Of a plane through the needle's axis and the target, or its +y where that is on the axis."""
    aside = np.zeros(3) if target is None else np.asarray(target, dtype=float) - needle.base_position
    aside = aside - (aside @ needle.axis) * needle.axis
    if np.linalg.norm(aside) < 1e-4:
        aside = rotate(needle.base_orientation, np.array([0.0, 1.0, 0.0]))
    return np.cross(needle.axis, aside)
