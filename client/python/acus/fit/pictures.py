# SPDX-License-Identifier: MIT
"""The picture of a fit. Needs matplotlib."""

import numpy as np

from ..study.pictures import BLUE, GREY, ORANGE, figure, save, short

SHOWN = {"s": (1.0, "s"), "m": (1e3, "mm"), "N": (1.0, "N")}
LABELS = {"time": ("time", "s"), "travel": ("way of the base", "m"), "force": ("axial resistance", "N"), "deflection": ("deflection of the tip", "m")}
MOST = 4  # measurements shown


def draw_fit(fitted, path, predictions):
    """A panel for each measurement, with what was predicted of it, and one of the correlations."""
    shown = [*zip(fitted.fit.measurements, fitted.curves)][:MOST]
    others = [each for each in predictions if each.name not in {measurement.name for measurement, _ in shown}]
    panels = len(shown) + len(others)
    made, axes = figure(5.2 * panels + 3.4, 4.2, 1, panels + 1, width_ratios=[1.6] * panels + [1])
    for place, (measurement, curve) in zip(axes[0], shown):
        draw_curves(place, measurement, curve, [each for each in predictions if each.name == measurement.name])
    for place, each in zip(axes[0][len(shown):], others):
        draw_prediction(place, each, 1.0, 1.0)
        place.set_title(str(each), fontsize=7)
    draw_correlation(axes[0][-1], fitted)
    save(made, path)


def draw_curves(place, measurement, curve, predictions):
    (x_name, x_unit), (y_name, y_unit) = LABELS[measurement.over], LABELS[measurement.of]
    (x_scale, x_unit), (y_scale, y_unit) = SHOWN[x_unit], SHOWN[y_unit]
    fitted = measurement.fitted
    place.plot(x_scale * measurement.x, y_scale * measurement.y, ".", color=GREY, markersize=4, label="measured")
    place.plot(x_scale * measurement.x[fitted], y_scale * curve.at(measurement.x[fitted]), color=BLUE, label="fitted")
    for each in predictions:
        draw_prediction(place, each, x_scale, y_scale, measured=False)
        place.axvline(x_scale * measurement.until, color=GREY, linewidth=0.6)
    place.set_xlabel(f"{x_name} ({x_unit})")
    place.set_ylabel(f"{y_name} ({y_unit})")
    place.set_title(measurement.name, fontsize=9)
    place.legend(fontsize=8, frameon=False)
    place.grid(True, color="#dddddd", linewidth=0.6)


def draw_prediction(place, prediction, x_scale, y_scale, measured=True):
    x = x_scale * prediction.x
    if measured:
        place.plot(x, y_scale * prediction.y, ".", color=GREY, markersize=4)
    place.fill_between(x, y_scale * prediction.low, y_scale * prediction.high, color=ORANGE, alpha=0.2, linewidth=0)
    place.plot(x, y_scale * prediction.simulated, color=ORANGE, label="predicted")


def draw_correlation(place, fitted):
    count = len(fitted.names)
    place.imshow(fitted.correlation, vmin=-1, vmax=1, cmap="RdBu_r")
    for i in range(count):
        for j in range(count):
            value = fitted.correlation[i][j]
            place.text(j, i, f"{value:+.2f}", ha="center", va="center", fontsize=8, color="white" if abs(value) > 0.6 else "black")
    names = [short(name) + (" *" if name in fitted.doubts else "") for name in fitted.names]
    place.set_xticks(np.arange(count), names, rotation=30, ha="right", fontsize=7)
    place.set_yticks(np.arange(count), names, fontsize=7)
    place.set_title("correlation" + (" (*: cannot be identified)" if fitted.doubts else ""), fontsize=9)
