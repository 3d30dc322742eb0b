"""Text on the thigh angles of Abhayasinghe et al., generated from the results."""

import numpy as np
import pandas as pd

from narx.experiments.method_labels import method_label, method_order
from narx.experiments.peak_errors import PEAKS
from narx.experiments.published import published
from narx.experiments.reports.report import Section

_HEADING = "**Where and why these results differ from the paper.** "
_VARIANTS = {
    "giof": "offset window of 1.5 s and a minimum duration of rest",
    "giof_two_strides": "the offset window follows the cadence, so the amplitude is preserved",
    "giof_as_printed": "a single sample that passes both tests counts as rest, although at the "
    "turning points of a swing the rate also passes through zero while the thigh accelerates",
    "giof_real_time": "causal, with a 10 Hz low-pass filter, which delays the signal by about "
    "20 ms, and a static offset instead of the moving average",
    "complementary_filter": "no prefilter, and the accelerometer is used at every sample, but "
    "with so small a weight (alpha = 0.9999) that over seconds the angle is the integrated rate",
    "complementary_filter_real_time": "the same with alpha = 0.999, also without the prefilter "
    "of the paper",
}
# an SD above this is divergence, not measurement error
_RUNAWAY_DEG = 15.0


_ABOUT_SIMULATION = (
    "The walkers are simulated (docs/simulator.md) and have no sex: the rows of Table 1 contain as "
    "many of them as the paper has men and women. Their reference is the bone, measured by "
    "markers on the skin, and the sensor is on soft tissue elsewhere on the thigh; in the paper "
    "both were in one box. Every walk starts from and stops in standing within a few steps, so "
    "every result includes starting and stopping. docs/experiments.md removes these effects one "
    "at a time."
)


def differences_from_paper(
    trials: pd.DataFrame, peaks: pd.DataFrame, method: str, mean_angle_deg: float, simulated: bool
) -> list[Section]:
    """Explain where and why the results differ from the paper.

    Parameters
    ----------
    trials, peaks : pandas.DataFrame
        From `narx.experiments.peak_errors.swing_results`.
    method : str
        Method to compare with the paper.
    mean_angle_deg : float
        Mean reference angle of the walks, degrees.
    simulated : bool
        Whether the walkers are simulated.

    Returns
    -------
    list of str
        Paragraphs.
    """
    mean = trials.groupby("method")[["r", "rmse_deg", "bias_deg", "precision_deg"]].mean()
    paragraphs: list[Section] = [_HEADING + _ranking(mean["r"])]
    if method in mean.index:
        paragraphs.append(_about_offset(mean.T[method], peaks, method, mean_angle_deg))
        paragraphs.append(_about_variants(mean, method))
    paragraphs += _about_runaways(mean["precision_deg"])
    if simulated:
        paragraphs.append(_ABOUT_SIMULATION)
    return paragraphs


def _about_variants(mean: pd.DataFrame, method: str) -> str:
    lines = [
        f"Compared with {method_label(method)} (mean r {mean['r'][method]:.4f}, SD of error "
        f"{mean['precision_deg'][method]:.2f}°), the other variants:\n"
    ]
    lines += [
        f"- {method_label(name)}: {mean['r'][name]:.4f}, {mean['precision_deg'][name]:.2f}°; "
        f"{_VARIANTS[name]}."
        for name in method_order(mean.index)
        if name in _VARIANTS and name != method
    ]
    return "\n".join(lines)


def _about_offset(mine: pd.Series, peaks: pd.DataFrame, method: str, mean_angle_deg: float) -> str:
    label = method_label(method)
    text = _published_text()
    peak = peaks[peaks["method"] == method].groupby("peak")["error_deg"].mean()
    positive, negative = (peak.get(kind, np.nan) - mine["bias_deg"] for kind in PEAKS)
    scaling = (
        "the swing is overestimated, the scaling error that the paper's Fig. 8 also shows"
        if negative > 0 > positive
        else "this is not the scaling error of the paper's Fig. 8"
    )
    return (
        f"{label}'s RMSE is {mine['rmse_deg']:.2f}° (paper {text['rmse_mean_deg']:.2f}°), of "
        f"which {mine['bias_deg']:+.2f}° is a constant error and {mine['precision_deg']:.2f}° "
        "the SD about it. Integrating the rate minus its moving average gives the angle minus "
        "*its* moving average, so the mean angle of a walk is lost, here "
        f"{mean_angle_deg:+.1f}°, until the thigh next comes to rest. The paper shows "
        "no such offset, so its waveforms were presumably aligned to a common mean, and only the "
        f"SD is comparable. In addition to the constant error, positive peaks have an error of "
        f"{positive:+.2f}° and negative peaks of {negative:+.2f}°: {scaling} (a window that "
        "is not a whole number of strides changes the amplitude; see docs/methods/giof.md)."
    )


def _about_runaways(precision_deg: pd.Series) -> list[Section]:
    ran = [m for m in method_order(precision_deg.index) if precision_deg[m] > _RUNAWAY_DEG]
    if not ran:
        return []
    return [
        f"{', '.join(method_label(m) for m in ran)} diverged: in minutes of walking with turns, "
        "integrating a single axis makes turns appear as flexion, and the accelerometer does not "
        "correct this, or not sufficiently. The walks in the paper are straight and short."
    ]


def _ranking(r: pd.Series) -> str:
    printed = published("abhayasinghe_table_1").set_index("group")["r_mean"]["All"]
    ours = ", ".join(f"{method_label(name)} {r[name]:.4f}" for name in method_order(r.index))
    return f"Mean correlation in the paper: GIOF {float(printed):.4f}. Here: {ours}."


def _published_text() -> pd.Series:
    return published("abhayasinghe_text").set_index("quantity")["value"].astype(float)
