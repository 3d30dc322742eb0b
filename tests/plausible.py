"""What reading an input may end with: plausible numbers, or one line for the user."""

import time
import traceback
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from narx.calibration.calibrate import calibrate
from narx.datasets import read_recording
from narx.datasets.base import TrialSource
from narx.datasets.layout import Layout
from narx.errors import UserError
from narx.inference.narx_method import NarxMethod
from narx.inference.predict import predict

LONGEST_S = 60.0
# a heading may accumulate many turns, but not within half a minute
_LARGEST = 100.0
_ROOT = Path(__file__).parents[1]


def fault(read: Callable[[], Iterable[np.ndarray]], named: str = "") -> str | None:
    """Describe what is wrong with the outcome of reading.

    Parameters
    ----------
    read : callable
        Reads, and returns angles in rad or rates in rad/s; missing ones are NaN.
    named : str
        What a refusal has to name.

    Returns
    -------
    str or None
        None if nothing is wrong.
    """
    begun_s = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            results = [np.asarray(one) for one in read()]
    except UserError as error:
        said = str(error)
        if "\n" in said or "\r" in said or named not in said:
            return f"message: {said!r}"
        results = []
    except Exception as error:
        return f"{error!r} at {_place(error)}"
    for numbers in results:
        known = numbers[np.isfinite(numbers)]
        if np.isinf(numbers).any() or (known.size and np.abs(known).max() > _LARGEST):
            return f"a number of {np.nanmax(np.abs(numbers)):g} in the result"
    took_s = time.process_time() - begun_s
    return f"took {took_s:.0f} s" if took_s > LONGEST_S else None


def angles_of(path: Path, method: NarxMethod, layout: Layout | None = None) -> np.ndarray:
    """Read a recording and estimate its angles.

    Parameters
    ----------
    path : pathlib.Path
        The recording.
    method : NarxMethod
        Estimates the angles.
    layout : Layout, optional
        Names of its columns.

    Returns
    -------
    ndarray, shape (N, 3)
        As many as it has samples, rad.
    """
    prediction = predict(read_recording(path, layout=layout), method, where=str(path))
    assert len(prediction.angles_rad) == len(prediction.time_s), "not an angle for each sample"
    return prediction.angles_rad


def fault_of_file(path: Path, method: NarxMethod) -> str | None:
    """Describe what is wrong with the outcome of reading a recording and of its angles.

    Parameters
    ----------
    path : pathlib.Path
        The recording.
    method : NarxMethod
        Estimates the angles.

    Returns
    -------
    str or None
        None if nothing is wrong.
    """
    return fault(lambda: [angles_of(path, method)], path.name)


def fault_of_set(open_set: Callable[[], TrialSource]) -> str | None:
    """Describe what is wrong with the outcome of reading the first trial of a data set.

    Parameters
    ----------
    open_set : callable
        Opens the data set.

    Returns
    -------
    str or None
        None if nothing is wrong.
    """

    def read() -> list[np.ndarray]:
        calibrated = calibrate(next(iter(open_set())))
        return [one.signals.axis_rates_rad_s for one in calibrated.values()]

    return fault(read)


def _place(error: Exception) -> str:
    """The line of this project in which an exception was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(frame.filename).is_relative_to(_ROOT / "narx")]
    last = (own or frames)[-1]
    return f"{Path(last.filename).name}:{last.lineno}"
