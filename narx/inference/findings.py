"""Problems of a recording: an error if it is certainly wrong, otherwise a note."""

import numpy as np
from numpy.typing import NDArray

from narx.errors import RecordingError
from narx.inference.narx_method import NarxMethod
from narx.kernels.clock import ARRIVED, DOUBTFUL, MISSING
from narx.recordings.consistency import contradiction, fit_rotation, is_certain
from narx.recordings.gaps import gaps_of
from narx.recordings.trial import ImuRecording
from narx.types import BoolArray, FloatArray

# about three strides
_SETTLED_S = 3.0
# in walking a shank turns 1.2 to 2 times as fast as its thigh, and no knee bends this far backwards
_EXCHANGED, _BACKWARDS_DEG = 1.1, 25.0


def check_consistency(
    gyroscope_rad_s: FloatArray,
    accelerometer_m_s2: FloatArray,
    sampling_rate_hz: float,
    *,
    is_leg: bool,
    where: str,
) -> list[str]:
    """Compare the gyroscope with the accelerometer.

    Parameters
    ----------
    gyroscope_rad_s, accelerometer_m_s2 : ndarray, shape (N, 3)
        Both on the same uniform clock, sensor frame.
    sampling_rate_hz : float
        Samples per second.
    is_leg : bool
        Whether it is a thigh or shank; other segments may be translated without rotation.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    list of str
        A note for segments other than the leg, and where the accelerations of walking may explain
        the contradiction; empty if the two agree.

    Raises
    ------
    RecordingError
        If the two sensors of a leg certainly contradict each other.
    """
    fit = fit_rotation(gyroscope_rad_s, accelerometer_m_s2, sampling_rate_hz)
    wrong = None if fit is None else contradiction(fit)
    if fit is None or wrong is None:
        return []
    if not is_leg or not is_certain(fit):
        return [f"{wrong}; or the sensor is translated more than it is rotated"]
    raise RecordingError(f"{where}: {wrong}; expected both sensors in one right-handed frame")


def gap_notes(recording: ImuRecording, max_gap_s: float) -> list[str]:
    """Describe the gaps.

    Parameters
    ----------
    recording : ImuRecording
        The sensor.
    max_gap_s : float
        Longest gap that is filled, s.

    Returns
    -------
    list of str
        A note each on gaps that are interpolated, filled, and left, if any.
    """
    gaps = gaps_of(recording.time_s, recording.gyroscope_rad_s, max_gap_s)
    lengths, left = gaps.lengths_s, gaps.left
    notes = []
    if gaps.interpolated.any():
        longest = lengths[gaps.interpolated].max()
        notes.append(f"{_gaps(gaps.interpolated)} of up to {longest:.3g} s interpolated")
    if gaps.filled.any():
        longest = lengths[gaps.filled].max()
        notes.append(
            f"{_gaps(gaps.filled)} of up to {longest:.3g} s filled from the rhythm of the recording"
        )
    if left.any():
        long = lengths[left].min() > max_gap_s
        which = f"longer than {max_gap_s:g} s" if long else "in a recording too short to fill them"
        notes.append(
            f"{_gaps(left)} {which} (together {lengths[left].sum():.3g} s, the "
            f"longest {lengths[left].max():.3g} s): the network pauses there, what was turned in "
            "them is lost, and the angles after them settle anew"
        )
    return notes


def start_up_note(
    method: NarxMethod, quality: NDArray[np.int8], sampling_rate_hz: float
) -> list[str]:
    """Report if the network never took over from the start-up, or had no time to settle.

    Parameters
    ----------
    method : NarxMethod
        Trained network.
    quality : ndarray of int8, shape (N,)
        From its `run`.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    list of str
        A note if all samples belong to the start-up, or the network ran for less than three
        seconds; otherwise empty.
    """
    there = quality[quality != MISSING]
    by_network_s = float(np.isin(there, (ARRIVED, DOUBTFUL)).sum()) / sampling_rate_hz
    if not there.size or by_network_s >= _SETTLED_S:
        return []
    if by_network_s > 0:
        return [
            f"too short: the network takes over {method.takes_over}, and ran for "
            f"{by_network_s:.2g} s; the angles have not settled"
        ]
    return [
        f"the network takes over {method.takes_over}, which this recording does not have: all "
        "angles are the start-up's"
    ]


def doubtful_note(quality: NDArray[np.int8]) -> list[str]:
    """Report if the motion is doubtful for most of the time.

    Parameters
    ----------
    quality : ndarray of int8, shape (N,)
        From `NarxMethod.run`.

    Returns
    -------
    list of str
        A note if this holds for more than half of the samples that the network estimated.
    """
    doubtful = int((quality == DOUBTFUL).sum())
    by_network = doubtful + int((quality == ARRIVED).sum())
    if 2 * doubtful <= by_network:
        return []
    return [
        f"in {100 * doubtful / by_network:.0f} % of the samples the motion does not resemble the "
        "swing of a leg, which is faster forward than backward, or the angle was corrected by "
        "several degrees (quality 4, with larger standard deviations): another motion, a sensor "
        "that slipped or is mounted the wrong way round"
    ]


def exchanged_note(
    thigh_rad_s: FloatArray, shank_rad_s: FloatArray, knee_rad: FloatArray
) -> list[str]:
    """Report a thigh and a shank that are probably exchanged.

    Parameters
    ----------
    thigh_rad_s, shank_rad_s : ndarray, shape (N,)
        Sagittal rates, rad/s; NaN where missing.
    knee_rad : ndarray, shape (N,)
        Flexion of the knee between them, rad.

    Returns
    -------
    list of str
        A note if the thigh turns more than the shank and the knee bends backwards; otherwise empty.
    """
    if not np.isfinite(knee_rad).any():
        return []
    thigh, shank = (np.sqrt(np.nanmean(rate**2)) for rate in (thigh_rad_s, shank_rad_s))
    low, middle, high = np.nanpercentile(np.degrees(knee_rad), [1, 50, 99])
    backwards = middle - low
    if thigh < _EXCHANGED * shank or backwards < max(_BACKWARDS_DEG, 1.5 * (high - middle)):
        return []
    return [
        f"the thigh turns {thigh / shank:.1f} times as fast as the shank, and the knee bends "
        f"{backwards:.0f} degrees backwards: are thigh and shank exchanged?"
    ]


def _gaps(flags: BoolArray) -> str:
    return f"{flags.sum()} gap{'' if flags.sum() == 1 else 's'}"
