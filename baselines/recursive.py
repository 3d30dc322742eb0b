"""Common base of methods that are a recursion of one axis."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from narx.baselines.heading import Heading
from narx.errors import UserError
from narx.inference.composition import Composition, start_up_of
from narx.inference.start_up import StartUp
from narx.kernels.recursions import (
    BEFORE,
    MEMORY,
    OUTPUT,
    RECURSIONS,
    Recursion,
    rates_of_angles,
    run_recursion,
)
from narx.method import OrientationMethod, SegmentSignals
from narx.recursion import Step
from narx.types import FloatArray

# inputs at one sample: the rates to integrate, and an extra input per axis
Inputs = Callable[[FloatArray, FloatArray], tuple[Any, Sequence[Any]]]
Constants = tuple[float, float, float]
# types of a start-up in a configuration
GivenStartUp = StartUp | Mapping[str, Any] | bool | None

_ALL = (0, 1, 2)
_NONE = (0.0, 0.0, 0.0)


class RecursiveMethod(OrientationMethod):
    """A recursion of one axis applied to three, with the parts of `narx.inference.composition`.

    A subclass gives its recursion, constants and extra inputs; coupling of the axes, start-up,
    washout and smoothing are common to all.

    Parameters
    ----------
    coupled : bool
        Integrate the rates of the angles, computed with the estimated tilt, instead of the
        gyroscope's rates.
    start_up : StartUp, mapping, bool, optional
        Estimate the posture first (`narx.inference.start_up`); True uses the default one.
    washout_s : float, optional
        Remove a constant deviation from the posture with this time constant, s.
    smoothing : bool
        Average a forward and a backward pass; whole recordings only.

    Raises
    ------
    UserError
        If one of them is invalid.
    """

    streams = True
    _recursion: ClassVar[Recursion]
    columns: Sequence[int] = _ALL
    # whether the output at the first sample is the initial angle; if not, it is filtered from zero
    holds_first: ClassVar[bool] = True

    def __init__(
        self,
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
    ) -> None:
        for name, value in (("coupled", coupled), ("smoothing", smoothing)):
            if not isinstance(value, bool):
                raise UserError(f"method {self.name}: {name} is {value!r}, expected true or false")
        self.coupled = coupled
        self.heading = Heading()
        self.composition = Composition(start_up_of(start_up, self.name), washout_s, smoothing)

    @abstractmethod
    def _parameters(self, interval_s: float) -> Constants:
        """Constants of the recursion, the sampling interval first."""

    def _inputs(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray | None]:
        """Rates to integrate, (N, 3), and extra inputs, (N, 3) or None."""
        return signals.axis_rates_rad_s, None

    def _inputs_one_by_one(self, sampling_rate_hz: float) -> Inputs:
        """The same for a stream, (3,) each."""
        return _RatesAlone()

    @property
    def _extras_are_angles(self) -> bool:
        """Whether the extra inputs are angles, which are relative to the posture."""
        return False

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        return not self.composition.smoothing

    @property
    def _couples_as_it_runs(self) -> bool:
        """Whether the recursion couples the axes; if not, its inputs are already coupled."""
        return self.coupled

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        if not signals.n_samples:
            return np.empty((0, 3))
        known = signals.axis_rates_rad_s, signals.interval_s, signals.initial_angles_rad
        angles = self.composition.estimate(_WholeRecording(self, signals), *known)
        angles[:, self._unobserved] = np.nan
        return self.heading.of(angles, *known, self.composition.start_up)

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        self.composition.refuse_stream(self.name)
        self.heading.refuse_stream(self.name)
        one_by_one = _OneByOne(self, sampling_rate_hz)
        composed = self.composition.stream(one_by_one, 1.0 / sampling_rate_hz, initial_angles_rad)
        return _ObservedAxes(composed, self._unobserved)

    @property
    def _unobserved(self) -> list[int]:
        # a start-up uses all three axes
        return [axis for axis in _ALL if axis not in self.columns]


@dataclass
class _ObservedAxes:
    """A step without the axes that the method does not observe."""

    composed: Step
    unobserved: list[int]

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        angles = self.composed(axis_rates, specific_force)
        angles[self.unobserved] = np.nan
        return angles


@dataclass
class _RatesAlone:
    """Inputs of a method without an extra input."""

    def __call__(
        self, axis_rates: FloatArray, specific_force: FloatArray
    ) -> tuple[FloatArray, Sequence[Any]]:
        return axis_rates, _NONE


class _Start:
    """Initial states, for whole recordings and for streams."""

    def __init__(self, method: RecursiveMethod) -> None:
        self.coupled, self.holds_start = method.coupled, method.holds_first
        self._method = method
        self._fresh = False

    def begin(self, initial_angles_rad: FloatArray | None) -> FloatArray:
        state = np.zeros((3, 3))
        self._fresh = self._method.holds_first
        if self._fresh and initial_angles_rad is not None:
            state[:, OUTPUT] = initial_angles_rad
        return state

    def take_over(
        self, deviation: FloatArray, previous_deviation: FloatArray, rates: FloatArray
    ) -> FloatArray:
        state = np.zeros((3, 3))
        state[:, OUTPUT], state[:, BEFORE] = deviation, rates
        self._fresh = False
        return state


class _WholeRecording(_Start):
    def __init__(self, method: RecursiveMethod, signals: SegmentSignals) -> None:
        super().__init__(method)
        self._interval_s = signals.interval_s
        self._rates, self._extras = method._inputs(signals)

    def run(
        self, samples: slice, backwards: bool, state: FloatArray, posture_rad: FloatArray
    ) -> FloatArray:
        method = self._method
        rates = -self._rates[samples] if backwards else self._rates[samples]
        out = np.full_like(rates, np.nan)
        if self._extras is None:
            extras = np.zeros_like(rates)
        else:
            extras = self._extras[samples]
            if method._extras_are_angles:
                extras = extras - posture_rad
        columns: NDArray[np.int64] = np.array(method.columns)
        run_recursion(
            RECURSIONS.index(type(method)._recursion),
            np.ascontiguousarray(rates),
            np.ascontiguousarray(extras),
            columns,
            method._parameters(self._interval_s),
            method._couples_as_it_runs,
            posture_rad,
            self._fresh,
            state,
            out,
        )
        return out


class _OneByOne(_Start):
    """Run sample by sample in plain arithmetic, which also works with counting numbers."""

    def __init__(self, method: RecursiveMethod, sampling_rate_hz: float) -> None:
        super().__init__(method)
        self._interval_s = 1.0 / sampling_rate_hz
        self._parameters = method._parameters(self._interval_s)
        self._inputs_of = method._inputs_one_by_one(sampling_rate_hz)
        self._rates: Any = None
        self._extras: Sequence[Any] = _NONE

    def observe(self, axis_rates: FloatArray, specific_force: FloatArray) -> None:
        self._rates, self._extras = self._inputs_of(axis_rates, specific_force)

    def step(self, state: Any, posture_rad: FloatArray) -> tuple[FloatArray, Any]:
        method, rates = self._method, self._rates
        if self.coupled:
            tilt = posture_rad + state[:, OUTPUT] + self._interval_s * state[:, BEFORE]
            sagittal, frontal, transverse = rates
            rates = rates_of_angles(sagittal, frontal, transverse, tilt[0], tilt[1])
        # counting numbers do not fit into an array of floats
        state = np.array(state, dtype=np.result_type(np.asarray(rates), float))
        angles = np.full(3, np.nan, dtype=state.dtype)
        for axis in method.columns:
            if not self._fresh:
                extra = self._extras[axis]
                if method._extras_are_angles and posture_rad[axis]:
                    extra = extra - posture_rad[axis]
                output, memory, before = state[axis]
                state[axis, OUTPUT], state[axis, MEMORY] = type(method)._recursion(
                    output, memory, before, rates[axis], extra, self._parameters
                )
            state[axis, BEFORE] = rates[axis]
            angles[axis] = state[axis, OUTPUT]
            if posture_rad[axis]:
                angles[axis] = angles[axis] + posture_rad[axis]
        self._fresh = False
        return angles, state
