"""Floating-point operations per sample of each method, counted by running it.

A method's step runs on numbers that count the operations on them. Abhayasinghe et al. (section
3.2) and Han et al. (section IV) compare methods by such counts for one angle.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from narx.baselines import two_point
from narx.errors import MethodNotApplicableError
from narx.kernels.gravity import tilt
from narx.kernels.recursions import integrate
from narx.method import OrientationMethod, SegmentSignals
from narx.types import FloatArray

OPERATIONS = ("additions", "multiplications", "divisions", "comparisons", "roots", "arctangents")


class CountedFloat:
    """A float that counts every operation on it.

    Parameters
    ----------
    value : float
        Its value.
    counts : collections.Counter
        Shared by all numbers of one run; keys are `OPERATIONS`.
    """

    __slots__ = ("counts", "value")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: float, counts: Counter[str]) -> None:
        self.value = value
        self.counts = counts

    def _note(self, operation: str, value: float) -> CountedFloat:
        self.counts[operation] += 1
        return CountedFloat(value, self.counts)

    def _compare(self, outcome: bool) -> bool:
        self.counts["comparisons"] += 1
        return outcome

    def __add__(self, other: CountedFloat | float) -> CountedFloat:
        return self._note("additions", self.value + float(other))

    def __sub__(self, other: CountedFloat | float) -> CountedFloat:
        return self._note("additions", self.value - float(other))

    def __rsub__(self, other: float) -> CountedFloat:
        return self._note("additions", float(other) - self.value)

    def __mul__(self, other: CountedFloat | float) -> CountedFloat:
        return self._note("multiplications", self.value * float(other))

    def __truediv__(self, other: CountedFloat | float) -> CountedFloat:
        return self._note("divisions", self.value / float(other))

    def __rtruediv__(self, other: float) -> CountedFloat:
        return self._note("divisions", float(other) / self.value)

    __radd__ = __add__
    __rmul__ = __mul__

    def __pow__(self, exponent: float) -> CountedFloat:
        if exponent != 0.5:
            raise NotImplementedError("only the square root is counted")
        return self.sqrt()

    def __neg__(self) -> CountedFloat:
        # a change of sign is not counted
        return CountedFloat(-self.value, self.counts)

    def __abs__(self) -> CountedFloat:
        return CountedFloat(abs(self.value), self.counts)

    def __lt__(self, other: CountedFloat | float) -> bool:
        return self._compare(self.value < float(other))

    def __le__(self, other: CountedFloat | float) -> bool:
        return self._compare(self.value <= float(other))

    def __gt__(self, other: CountedFloat | float) -> bool:
        return self._compare(self.value > float(other))

    def __ge__(self, other: CountedFloat | float) -> bool:
        return self._compare(self.value >= float(other))

    def __float__(self) -> float:
        return self.value

    def __round__(self) -> int:
        return round(self.value)

    def sqrt(self) -> CountedFloat:
        """Square root; `numpy.sqrt` calls this.

        Returns
        -------
        CountedFloat
            The root.
        """
        return self._note("roots", math.sqrt(self.value))

    def arctan2(self, other: CountedFloat | float) -> CountedFloat:
        """Arctangent of two arguments; `numpy.arctan2` calls this.

        Parameters
        ----------
        other : CountedFloat or float
            Denominator.

        Returns
        -------
        CountedFloat
            The angle.
        """
        return self._note("arctangents", math.atan2(self.value, float(other)))


def counted(values: FloatArray, counts: Counter[str]) -> Any:
    """Convert an array to one of counting numbers.

    Parameters
    ----------
    values : ndarray
        Numbers.
    counts : collections.Counter
        Counter of their operations.

    Returns
    -------
    ndarray of object
        The same shape.
    """
    out = np.empty(values.shape, dtype=object)
    for index, value in np.ndenumerate(values):
        out[index] = CountedFloat(float(value), counts)
    return out


def count_stream(method: OrientationMethod, signals: SegmentSignals) -> dict[str, float]:
    """Count the operations of a method per sample, on average over a recording.

    Parameters
    ----------
    method : OrientationMethod
        Method that runs sample by sample and whose step is plain arithmetic.
    signals : SegmentSignals
        Signals without missing samples. The number of operations may differ between samples.

    Returns
    -------
    dict of str to float
        By operation (`OPERATIONS`), mean per sample after the first, over all axes that the
        method estimates.

    Raises
    ------
    MethodNotApplicableError
        If the method does not run sample by sample.
    """
    if not method.streams:
        raise MethodNotApplicableError(f"method {method.name} does not run sample by sample")
    step = method._step(signals.sampling_rate_hz, None)
    counts: Counter[str] = Counter()
    for k in range(signals.n_samples):
        if k == 1:
            counts.clear()  # the first sample initialises the state
        step(
            counted(signals.axis_rates_rad_s[k], counts),
            counted(signals.specific_force_m_s2[k], counts),
        )
    if not counts.total():
        raise MethodNotApplicableError(
            f"method {method.name} runs in a compiled library, where operations cannot be counted"
        )
    return _per(counts, signals.n_samples - 1)


def count_two_point(signals: SegmentSignals) -> dict[str, float]:
    """Count the operations of the 2-point method between A and B, on average per sample and angle.

    Parameters
    ----------
    signals : SegmentSignals
        Of one walk, from A to B, without missing samples.

    Returns
    -------
    dict of str to float
        By operation (`OPERATIONS`), mean per sample and angle; the arctangents are those of
        both tilt axes at A and B, shared by all samples of three angles.

    Notes
    -----
    With the rectangular rule, as in the paper. The paper's count, 7 additions and 4
    multiplications, results if eqs. (9) to (14) are evaluated as printed, with the error at A and
    B and ``B - A`` recomputed for every angle.
    """
    counts: Counter[str] = Counter()
    ends = [counted(signals.specific_force_m_s2[k], counts) for k in (0, -1)]
    at_start, at_stop = (
        np.array([tilt(False, *force), tilt(True, *force), CountedFloat(0.0, counts)])
        for force in ends
    )
    rates = counted(signals.axis_rates_rad_s, counts)
    constants = signals.interval_s, 0.0, 0.0  # 0: the rectangle
    gyroscope = np.tile(at_start, (len(rates), 1))
    for k, axis in np.ndindex(len(rates) - 1, 3):
        before, rate = rates[k : k + 2, axis]
        gyroscope[k + 1, axis], _ = integrate(gyroscope[k, axis], 0.0, before, rate, 0.0, constants)
    errors = gyroscope[0] - at_start, gyroscope[-1] - at_stop
    drift = two_point._drift_line(*errors, len(gyroscope))
    two_point._compensate(gyroscope, drift)
    return _per(counts, 3 * signals.n_samples)


def _per(counts: Counter[str], number: int) -> dict[str, float]:
    return {operation: counts[operation] / max(1, number) for operation in OPERATIONS}


def operation_table(
    signals: SegmentSignals, methods: Mapping[str, OrientationMethod]
) -> pd.DataFrame:
    """Count the operations of several methods over the same walk.

    Parameters
    ----------
    signals : SegmentSignals
        Without missing samples. A few seconds are enough; the counting is slow.
    methods : mapping of str to OrientationMethod
        By the name of the row. Methods that cannot be counted are rows of NaN.

    Returns
    -------
    pandas.DataFrame
        One row per method, one column per operation: mean number per sample, for all angles that
        the method estimates (`TwoPoint`: for one angle).
    """
    rows = {}
    for name, method in methods.items():
        try:
            if isinstance(method, two_point.TwoPoint):
                rows[name] = count_two_point(signals)
            else:
                rows[name] = count_stream(method, signals)
        except MethodNotApplicableError:
            rows[name] = dict.fromkeys(OPERATIONS, float("nan"))
    return pd.DataFrame.from_dict(rows, orient="index", columns=list(OPERATIONS))
