"""Start-up, washout and smoothing, which can be combined with any recursion.

The recursion itself (a network, a leaky integrator, a complementary filter) computes angles from
rates. The parts around it do not depend on the recursion: the start-up estimates the posture and
hands over, the washout removes constant deviations, smoothing averages a forward and a backward
pass. Methods that share these parts differ only in the recursion.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol, TypeVar

import numpy as np

from narx.errors import MethodNotApplicableError, UserError
from narx.inference.smoothing import forward_share, time_reversed
from narx.inference.start_up import StartUp
from narx.inference.tracker import PostureTracker
from narx.inference.washout import wash_out, washout_gain
from narx.recursion import Step
from narx.types import FloatArray

Part = TypeVar("Part", StartUp, PostureTracker)


class Startable(Protocol):
    """A recursion that can be started from any angles."""

    coupled: bool
    # whether it begins at a known start pose, without a start-up; if not, at zero
    holds_start: bool

    def begin(self, initial_angles_rad: FloatArray | None) -> Any:
        """Start without a start-up.

        Parameters
        ----------
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose.

        Returns
        -------
        object
            State before the first sample.
        """
        ...

    def take_over(
        self, deviation: FloatArray, previous_deviation: FloatArray, rates: FloatArray
    ) -> Any:
        """Start from the result of the start-up.

        Parameters
        ----------
        deviation, previous_deviation : ndarray, shape (3,)
            Last two angles relative to the posture, rad.
        rates : ndarray, shape (3,)
            Last integrated rates, rad/s.

        Returns
        -------
        object
            State before the next sample.
        """
        ...


class Recursion(Startable, Protocol):
    """A recursion over the samples of one recording."""

    def run(
        self, samples: slice, backwards: bool, state: Any, posture_rad: FloatArray
    ) -> FloatArray:
        """Run over some samples.

        Parameters
        ----------
        samples : slice
            Samples of the recording; a negative step runs backwards.
        backwards : bool
            Reverse the sign of the rates.
        state : object
            From `begin` or `take_over`.
        posture_rad : ndarray, shape (3,)
            Posture, the zero of the recursion, rad.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles including the posture, rad.
        """
        ...


class StepRecursion(Startable, Protocol):
    """A recursion one sample at a time."""

    def observe(self, axis_rates: FloatArray, specific_force: FloatArray) -> None:
        """Receive the next sample, also during the start-up.

        Parameters
        ----------
        axis_rates, specific_force : ndarray, shape (3,)
            Rates in rad/s and specific force in m/s^2.
        """
        ...

    def step(self, state: Any, posture_rad: FloatArray) -> tuple[Any, Any]:
        """Estimate the angles at the last sample received.

        Parameters
        ----------
        state : object
            From `begin`, `take_over` or the previous step.
        posture_rad : ndarray, shape (3,)
            Posture, the zero of the recursion, rad.

        Returns
        -------
        angles : ndarray, shape (3,)
            Angles including the posture, rad.
        state : object
            State after the sample.
        """
        ...


def start_up_of(given: object, method: str) -> StartUp | None:
    """Build a start-up from a configuration value.

    Parameters
    ----------
    given : StartUp, mapping, bool or None
        True for the default start-up; a mapping gives its parameters.
    method : str
        Name of the method, for the message.

    Returns
    -------
    StartUp or None
        Start-up; None if there is none.

    Raises
    ------
    UserError
        If the value is not one of these.
    """
    return _part("start_up", StartUp, given, method)


def tracker_of(given: object, method: str) -> PostureTracker | None:
    """Build a tracker from a configuration value.

    Parameters
    ----------
    given : PostureTracker, mapping, bool or None
        True is the default tracker; a mapping holds its parameters.
    method : str
        Name of the method, for the message.

    Returns
    -------
    PostureTracker or None
        None for none.

    Raises
    ------
    UserError
        If the value is not one of these.
    """
    return _part("tracker", PostureTracker, given, method)


def _part(name: str, kind: type[Part], given: object, method: str) -> Part | None:
    if given is None or given is False:
        return None
    if given is True:
        return kind()
    if isinstance(given, kind):
        return given
    if isinstance(given, Mapping):
        known = [field.name for field in fields(kind)]
        unknown = [str(key) for key in given if key not in known]
        if unknown:
            raise UserError(
                f"method {method}: {name} has no parameter '{unknown[0]}', expected some of "
                f"{', '.join(known)}"
            )
        return kind(**{str(key): value for key, value in given.items()})
    raise UserError(f"method {method}: {name} is {given!r}, expected true, null, or its parameters")


@dataclass(frozen=True)
class Composition:
    """A start-up, a washout and smoothing around any recursion.

    Parameters
    ----------
    start_up : StartUp, optional
        Estimates the posture before the recursion takes over; None starts the recursion
        immediately.
    washout_s : float, optional
        Time constant with which a constant deviation from the posture is removed, s; None for no
        washout.
    smoothing : bool
        Average a forward and a backward pass; whole recordings only.

    Raises
    ------
    UserError
        If the washout is not positive.
    """

    start_up: StartUp | None = None
    washout_s: float | None = None
    smoothing: bool = False

    def __post_init__(self) -> None:
        washout_gain(self.washout_s, 1.0)

    def estimate(
        self,
        recursion: Recursion,
        axis_rates_rad_s: FloatArray,
        interval_s: float,
        initial_angles_rad: FloatArray | None,
    ) -> FloatArray:
        """Estimate the angles of a recording.

        Parameters
        ----------
        recursion : Recursion
            Recursion over this recording.
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes, no NaN, rad/s; integrated by the start-up.
        interval_s : float
            Sampling interval, s.
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles, rad.
        """
        rates = axis_rates_rad_s
        first = np.empty((0, 3))
        posture = np.zeros(3)
        state = None
        if self.start_up is not None:
            begun = self.start_up.begin(initial_angles_rad)
            first = self.start_up.run(rates, interval_s, begun, recursion.coupled)
            if len(first):
                posture, *followed = StartUp.hand_over(begun, interval_s)
                state = recursion.take_over(*followed)
        n = len(first)
        if not n:
            state = recursion.begin(initial_angles_rad)
        gain = washout_gain(self.washout_s, interval_s)
        rest = recursion.run(slice(n, None), False, state, posture)
        angles = np.concatenate([first, wash_out(rest, posture, gain, np.zeros(3))])
        if not self.smoothing or not len(rest):
            return angles
        # the same kinematics with time reversed
        state = recursion.take_over(
            *time_reversed(recursion.coupled, rates[-1], angles[-1], posture, interval_s)
        )
        back = recursion.run(slice(-2, None, -1), True, state, posture)
        back = wash_out(back, posture, gain, np.zeros(3))
        back = np.concatenate([back[::-1], angles[-1:]])
        known = initial_angles_rad is not None and (n > 0 or recursion.holds_start)
        settling_s = self.start_up.duration_s if self.start_up and n else StartUp.duration_s
        share = forward_share(len(angles), n, round(settling_s / interval_s), known)
        return share * angles + (1.0 - share) * back

    def refuse_stream(self, method: str) -> None:
        """Refuse to run sample by sample with smoothing, which needs the whole recording.

        Parameters
        ----------
        method : str
            Name, for the message.

        Raises
        ------
        MethodNotApplicableError
            With smoothing.
        """
        if self.smoothing:
            raise MethodNotApplicableError(
                f"{method}: smoothing needs the whole recording, use smoothing=false"
            )

    def stream(
        self, recursion: StepRecursion, interval_s: float, initial_angles_rad: FloatArray | None
    ) -> Step:
        """Run sample by sample.

        Parameters
        ----------
        recursion : StepRecursion
            New recursion.
        interval_s : float
            Sampling interval, s.
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose.

        Returns
        -------
        callable
            ``step(axis_rates (3,), specific_force (3,)) -> angles (3,)``.
        """
        return _ComposedStep(self, recursion, interval_s, initial_angles_rad)


class _ComposedStep:
    def __init__(
        self,
        composition: Composition,
        recursion: StepRecursion,
        interval_s: float,
        initial_angles_rad: FloatArray | None,
    ) -> None:
        start_up = composition.start_up
        self.recursion, self.start_up, self.interval_s = recursion, start_up, interval_s
        self.gain = washout_gain(composition.washout_s, interval_s)
        self.posture, self.mean = np.zeros(3), np.zeros(3)
        self.begun = None if start_up is None else start_up.begin(initial_angles_rad)
        self.starting = start_up is not None and start_up.duration_s > 0
        self.state = None if self.starting else recursion.begin(initial_angles_rad)

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        recursion, start_up, begun = self.recursion, self.start_up, self.begun
        recursion.observe(axis_rates, specific_force)
        if self.starting and start_up is not None and begun is not None:
            interval_s = self.interval_s
            angles = start_up.run(axis_rates[None], interval_s, begun, recursion.coupled)[0]
            if start_up.is_over(begun):
                self.starting = False
                self.posture, *followed = StartUp.hand_over(begun, interval_s)
                self.state = recursion.take_over(*followed)
            return np.asarray(angles)
        output, self.state = recursion.step(self.state, self.posture)
        if not self.gain:
            return np.asarray(output)
        return wash_out(output[None], self.posture, self.gain, self.mean)[0]
