# SPDX-License-Identifier: MIT
"""What a study looks like: what its outputs depend on, and how far a point spreads. Needs matplotlib."""

import numpy as np

from ..errors import StudyError
from .sensitivity import swings

UNITS = {"peak_force": "N", "end_force": "N", "puncture_force": "N", "puncture_travel": "m", "work": "J", "depth": "m",
         "deflection": "m", "path_length": "m", "swept_volume": "m³", "tip": "m", "tip.x": "m", "tip.y": "m", "tip.z": "m",
         "distance": "m"}
SCALES = {"m": (1e3, "mm"), "m³": (1e9, "mm³"), "J": (1e3, "mJ")}  # as they are shown
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#999999"
MOST_PARAMETERS, MOST_OUTPUTS = 8, 6
MM = 1e3  # per m
SHARES = (0.5, 0.95)  # of the cases, within the ellipses


def figure(width, height, rows, columns, **settings):
    try:
        from matplotlib.figure import Figure  # pylint: disable=import-outside-toplevel  # takes a second
    except ImportError:
        raise StudyError("pictures need matplotlib (apt install python3-matplotlib)") from None
    made = Figure((width, height), layout="constrained")
    return made, made.subplots(rows, columns, squeeze=False, **settings)


def save(made, path):
    from ..drawing.figures import save as save_figure  # pylint: disable=import-outside-toplevel  # with matplotlib
    save_figure(made, path)


def labelled(name, values):
    """Values as they are shown, and the label of their axis."""
    scale, unit = SCALES.get(UNITS.get(name), (1, UNITS.get(name)))
    return np.asarray(values, dtype=float) * scale, f"{name} ({unit})" if unit else name


def short(name):
    """The field alone, with what tells it from others: skin: young_modulus."""
    *within, field = name.split(".")
    brackets = [part.partition("[")[2].rstrip("]") for part in within if "[" in part]
    return f"{brackets[-1]}: {field}" if brackets and not brackets[-1].isdigit() else field


def draw_sensitivity(study, path, values, of):
    """A row for each output, {name: its values by case}: what each parameter changes (tornado), then the cases over each
    parameter. `of`: how many outputs there are."""
    columns = {name: [study.definition.design[case][name] for case in range(len(study))] for name in study.parameters}
    found = {output: swings(columns, each) for output, each in values.items()}
    varied = [name for name in columns if any(name in each for each in found.values())]
    names = varied[:MOST_PARAMETERS]
    if not names:
        raise StudyError("a picture needs a parameter of numbers that varies and cases that have run")
    made, axes = figure(4 + 2.3 * len(names), 2.6 * len(values), len(values), len(names) + 1,
                        width_ratios=[1.6] + [1] * len(names))
    for row, output in zip(axes, values):
        draw_tornado(row[0], output, found[output], values[output])
        for place, name in zip(row[1:], names):
            draw_scatter(place, name, columns[name], output, values[output])
        row[1].set_ylabel(labelled(output, [])[1], fontsize=8)
        for place, title in zip(row[1:], titles_of(study, output, names)):
            place.set_title(title, fontsize=7)
    left_out = [f"{len(shown)} of {count} {what}" for shown, count, what in (
        (names, len(columns), "parameters"), (values, of, "outputs")) if len(shown) < count]
    made.suptitle(f"{study.definition.scene.fields.get('name', 'scene')}: {len(study.rows)} cases"
                  + (f" ({', '.join(left_out)} are shown)" if left_out else ""), fontsize=10)
    save(made, path)


def titles_of(study, output, names):
    """The Sobol indices of each parameter, where the design gives them."""
    try:
        indices = {each.name: each for each in study.indices(output)}
    except StudyError:  # another design, too few cases, or they are all alike
        return []
    return [f"first order {indices[name].first:.2f}, total {indices[name].total:.2f}" for name in names]


def ranked(sizes):
    """Names, the largest first."""
    return sorted(sizes, key=sizes.get, reverse=True)


def draw_tornado(axes, output, found, values):
    """Bars from the mean of the output at low values of a parameter to that at high ones."""
    shown, label = labelled(output, values)
    scale = labelled(output, [1.0])[0][0]
    middle = shown[np.isfinite(shown)].mean()
    names = ranked({name: abs(high - low) for name, (low, high) in found.items()})[:MOST_PARAMETERS]
    for place, name in enumerate(reversed(names)):
        for end, colour in zip(found[name], (BLUE, ORANGE)):
            axes.barh(place, scale * end - middle, color=colour, height=0.6)
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_yticks(range(len(names)), [short(name) for name in reversed(names)], fontsize=7)
    axes.set_xlabel(f"change from mean {middle:.5g} of {label}", fontsize=8)
    axes.set_title("at low (blue), high (orange) values", fontsize=7)
    axes.locator_params(axis="x", nbins=5)
    axes.tick_params(labelsize=7, which="both")


def draw_scatter(axes, name, column, output, values):
    x, y = np.asarray(column, dtype=float), labelled(output, values)[0]
    x, y = np.where(np.isfinite(y), x, np.nan), np.where(np.isfinite(y), y, np.nan)
    axes.plot(x, y, ".", color=GREY, markersize=3, alpha=0.6)
    middle = running_mean(x, y)
    axes.plot(*middle, color=BLUE, linewidth=1.4)
    if is_logarithmic(x):
        axes.set_xscale("log")
    axes.set_xlabel(short(name), fontsize=8)
    axes.tick_params(labelsize=7, which="both")


def is_logarithmic(x, ratio=3.5):
    """Whether values spread over factors: half of them below the geometric rather than the arithmetic middle."""
    x = x[np.isfinite(x)]
    if not x.size or x.min() <= 0 or x.max() / x.min() < ratio:
        return False
    geometric, middle = np.sqrt(x.min() * x.max()), (x.min() + x.max()) / 2
    return abs(np.median(x) - geometric) < abs(np.median(x) - middle)


def running_mean(x, y, parts=10):
    """Means of x and y in parts of as many cases, or at each value of x where there are few."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    groups = [np.flatnonzero(x == each) for each in np.unique(x)]
    if len(groups) > 2 * parts:
        groups = [each for each in np.array_split(np.argsort(x, kind="stable"), parts) if each.size]
    return [x[each].mean() for each in groups], [y[each].mean() for each in groups]


def draw_spread(study, path, output):
    """The points of all cases, seen along and from two sides of the world's axes, with ellipses around half of them and
    around 95 % of them as far as they are normally distributed."""
    points = np.stack([study.values(f"{output}.{axis}") for axis in "xyz"], axis=1)
    points = MM * points[np.all(np.isfinite(points), axis=1)]
    if len(points) < 3:
        raise StudyError(f"a picture of the spread needs three cases with a point '{output}' or more, found {len(points)}")
    middle = points.mean(axis=0)
    made, axes = figure(10, 3.8, 1, 3)
    for place, (i, j) in zip(axes[0], ((0, 1), (0, 2), (1, 2))):
        place.plot(points[:, i], points[:, j], ".", color=GREY, markersize=3)
        for share, colour in zip(SHARES, (ORANGE, BLUE)):
            place.plot(*ellipse(points[:, [i, j]], share), color=colour, linewidth=1.2, label=f"{share:.0%}")
        place.plot(middle[i], middle[j], "+", color="black", markersize=9)
        place.set_xlabel(f"{'xyz'[i]} (mm)")
        place.set_ylabel(f"{'xyz'[j]} (mm)")
        place.set_aspect("equal", adjustable="datalim")
        place.grid(True, color="#dddddd", linewidth=0.6)
        place.set_axisbelow(True)
    axes[0, 0].legend(fontsize=7)
    deviation = points.std(axis=0, ddof=1)
    made.suptitle(f"{output} in {len(points)} cases: mean ({', '.join(f'{each:.2f}' for each in middle)}) mm, "
                  f"standard deviation ({', '.join(f'{each:.2f}' for each in deviation)}) mm", fontsize=10)
    save(made, path)


def ellipse(points, share):
    """x and y of the curve within which a share of a normal distribution with the points' mean and covariance lies."""
    values, axes = np.linalg.eigh(np.cov(points.T))
    radius = np.sqrt(-2 * np.log(1 - share) * np.clip(values, 0, None))
    angle = np.linspace(0, 2 * np.pi, 100)
    return points.mean(axis=0)[:, None] + axes @ (radius[:, None] * [np.cos(angle), np.sin(angle)])
