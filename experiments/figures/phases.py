"""Thigh angle, gyroscope and its derivative with the phases marked: Abhayasinghe et al. Fig. 11."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from narx.experiments.figures.canvas import legend_below, panels, styled


@styled
def phases(
    time_s: ArrayLike,
    angle_rad: ArrayLike,
    rate_rad_s: ArrayLike,
    events_s: Mapping[str, ArrayLike],
    truth_s: Mapping[str, ArrayLike] | None = None,
) -> Figure:
    """Draw the three waveforms, each divided by its peak, and the points of the gait cycle.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Clock of a stride or two, s.
    angle_rad : array_like, shape (N,)
        Sagittal thigh angle.
    rate_rad_s : array_like, shape (N,)
        Sagittal gyroscope, low-pass filtered as for the detection of events.
    events_s : mapping of str to array_like
        Times of the points ``a`` to ``g``; those outside the clock are left out.
    truth_s : mapping of str to array_like, optional
        Times of true events by name, drawn as triangles below.

    Returns
    -------
    matplotlib.figure.Figure
        One panel, time from its first sample.
    """
    time = np.asarray(time_s, dtype=float)
    angle, rate = np.asarray(angle_rad, dtype=float), np.asarray(rate_rad_s, dtype=float)
    figure, grid = panels(1, 1, 6.4, 3.0)
    panel = grid[0, 0]
    for values, name, colour in (
        (angle, "thigh angle", "#0060b0"),
        (rate, "gyroscope", "#c8102e"),
        (np.gradient(rate, time), "derivative of gyroscope", "#e69f00"),
    ):
        peak = np.nanmax(np.abs(values))
        panel.plot(
            time - time[0],
            values / (peak if peak > 0 else 1.0),
            label=name,
            color=colour,
            linewidth=1.5 if name == "thigh angle" else 1.0,
        )
    panel.axhline(0.0, color="0.4", linewidth=0.7)
    for point, times in events_s.items():
        for moment in np.atleast_1d(np.asarray(times, dtype=float)):
            if not time[0] <= moment <= time[-1]:
                continue
            height = np.interp(moment, time, angle) / (np.nanmax(np.abs(angle)) or 1.0)
            panel.axvline(moment - time[0], color="0.75", linewidth=0.7, zorder=0)
            panel.plot(moment - time[0], height, "o", color="#0060b0", markersize=4)
            panel.annotate(
                point,
                (moment - time[0], height),
                xytext=(4, 4),
                textcoords="offset points",
                fontweight="bold",
            )
    markers = iter(("^", "v", "s", "D"))
    for name, times in (truth_s or {}).items():
        moments = np.atleast_1d(np.asarray(times, dtype=float))
        moments = moments[(moments >= time[0]) & (moments <= time[-1])] - time[0]
        panel.plot(
            moments,
            np.full(len(moments), -1.12),
            next(markers, "x"),
            color="k",
            markersize=5,
            label=f"true {name.replace('_', ' ')}",
        )
    panel.set(xlabel="time (s)", ylabel="divided by its peak", ylim=(-1.2, 1.25))
    panel.margins(x=0)
    legend_below(figure, panel)
    return figure
