"""Amplitude spectrum of a gyroscope with its major components: Tham et al. Fig. 3."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from narx.experiments.figures.canvas import panels, styled
from narx.gait.spectrum import component_powers, single_sided_amplitude_spectrum


@styled
def spectrum(
    sagittal_rate_rad_s: ArrayLike,
    sampling_rate_hz: float,
    power_fraction: float = 0.98,
    highest_hz: float = 10.0,
    title: str = "Single-sided amplitude spectrum of the gyroscope",
) -> Figure:
    """Draw the spectrum and mark the components with most of the power.

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate about the sagittal axis during walking, without missing samples.
    sampling_rate_hz : float
        Sampling rate.
    power_fraction : float
        Share of the power in the marked components together.
    highest_hz : float
        Right end of the frequency axis.
    title : str
        Title of the panel.

    Returns
    -------
    matplotlib.figure.Figure
        Amplitude in deg/s; marked components are those that `narx.gait.spectrum.hidden_neurons`
        counts, numbered from the strongest, each with the cumulative power.

    Raises
    ------
    UserError
        If the signal shows no walking, or has missing samples.
    """
    frequency_hz, amplitude = single_sided_amplitude_spectrum(sagittal_rate_rad_s, sampling_rate_hz)
    stride_hz, power = component_powers(sagittal_rate_rad_s, sampling_rate_hz)
    order = np.argsort(power)[::-1]
    held = np.cumsum(power[order])
    count = min(int(np.searchsorted(held, power_fraction)) + 1, len(power))
    amplitude_deg = np.rad2deg(amplitude)

    figure, grid = panels(1, 1, 6.0, 2.7)
    panel = grid[0, 0]
    shown = (frequency_hz > 0) & (frequency_hz <= highest_hz)
    panel.plot(frequency_hz[shown], amplitude_deg[shown], color="#0060b0", linewidth=0.8)
    for rank in range(count):
        centre = (order[rank] + 1) * stride_hz
        band = np.abs(frequency_hz - centre) <= stride_hz / 2
        peak = int(np.flatnonzero(band)[np.argmax(amplitude_deg[band])])
        if frequency_hz[peak] > highest_hz:
            continue
        panel.plot(frequency_hz[peak], amplitude_deg[peak], "o", color="#c8102e", markersize=4)
        panel.annotate(
            f"{rank + 1}: {100 * held[rank]:.1f} %",
            (frequency_hz[peak], amplitude_deg[peak]),
            xytext=(5, 3),
            textcoords="offset points",
            color="#c8102e",
        )
    plural = "component holds" if count == 1 else "components hold"
    panel.set_title(
        f"{count} {plural} {100 * held[count - 1]:.1f} % of the power (stride {stride_hz:.2f} Hz); "
        "at each: its rank, and the power of all up to it",
        fontweight="normal",
    )
    panel.set(xlabel="frequency (Hz)", ylabel="amplitude (°/s)", xlim=(0, highest_hz))
    panel.set_ylim(bottom=0)
    figure.suptitle(title)
    return figure
