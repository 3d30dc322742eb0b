"""Clock of a simulated motion, and recordings of the sensors on it."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose
from narx.recordings.trial import ImuRecording
from narx.simulation.calculus import EDGE
from narx.simulation.inertial import angular_rate, specific_force
from narx.simulation.random_numbers import stream
from narx.simulation.sensor import SensorModel, measure
from narx.simulation.session import Session
from narx.simulation.skeleton import SkeletonMotion
from narx.simulation.walking import MARGIN_S
from narx.types import FloatArray

# motion is computed at least at this rate, whatever that of the sensors
MOTION_RATE_HZ = 500.0


@dataclass(frozen=True)
class Recorder:
    """Records a session's sensors.

    Parameters
    ----------
    sampling_rate_hz : float
        Of the recordings.
    sensor : SensorModel
        Product.
    ideal : bool
        Whether sensors are exact, and the skin does not move.
    seed : int
        Seed of the data set.
    """

    sampling_rate_hz: float
    sensor: SensorModel
    ideal: bool
    seed: int

    @property
    def every(self) -> int:
        """Number of motion samples per sample of a recording."""
        return int(np.ceil(MOTION_RATE_HZ / self.sampling_rate_hz))

    def clock_s(self, length_s: float) -> tuple[FloatArray, float]:
        """Return the clock of a motion: a multiple of the sampling rate, longer at both ends.

        Parameters
        ----------
        length_s : float
            Of the recording.

        Returns
        -------
        time_s : ndarray, shape (N,)
            Clock.
        rate_hz : float
            Its rate.
        """
        every = self.every
        rate_hz = every * self.sampling_rate_hz
        margin = every * (int(np.ceil(MARGIN_S * self.sampling_rate_hz)) + EDGE)
        n = every * round(length_s * self.sampling_rate_hz)
        return np.arange(-margin, n + margin) / rate_hz, rate_hz

    def kept(self, motion_time_s: FloatArray) -> slice:
        """Select the samples of a motion's clock that belong to the recording.

        Parameters
        ----------
        motion_time_s : ndarray, shape (N,)
            As from `clock_s`.

        Returns
        -------
        slice
            Of the N samples.
        """
        margin = round(-motion_time_s[0] * self.every * self.sampling_rate_hz)
        return slice(margin, len(motion_time_s) - margin, self.every)

    def orientation(
        self, segment: str, motion: SkeletonMotion, session: Session, moved: Rotation | None = None
    ) -> Rotation:
        """Orientation of a sensor.

        Parameters
        ----------
        segment : str
            Where it is.
        motion : SkeletonMotion
            Of the segments.
        session : Session
            Mounting and tissue.
        moved : scipy.spatial.transform.Rotation, optional
            Motion relative to the segment, from `narx.simulation.attachment`.

        Returns
        -------
        scipy.spatial.transform.Rotation
            Sensor to global, at every sample of the motion.
        """
        skin = motion.orientations[segment]
        if not self.ideal:
            skin = compose(skin, session.tissues[segment].rotation(motion))
        if moved is not None:
            skin = compose(skin, moved)
        return compose(skin, session.mountings[segment].orientation)

    def record(
        self,
        segment: str,
        motion: SkeletonMotion,
        session: Session,
        names: tuple[str, ...],
        moved: Rotation | None = None,
    ) -> ImuRecording:
        """Record a motion by the sensor of a segment.

        Parameters
        ----------
        segment : str
            Where the sensor is.
        motion : SkeletonMotion
            Of the segments.
        session : Session
            Instruments.
        names : tuple of str
            Name of the recording, which determines its noise.
        moved : scipy.spatial.transform.Rotation, optional
            As for `orientation`.

        Returns
        -------
        ImuRecording
            On the recording's clock.
        """
        orientation = self.orientation(segment, motion, session, moved)
        rate = angular_rate(orientation, motion.rate_hz)
        offset = session.mountings[segment].offset_m
        force = specific_force(orientation, motion.acceleration(segment, offset))
        return self.measured(segment, rate, force, motion.time_s, session, names)

    def measured(
        self,
        segment: str,
        rate: FloatArray,
        force: FloatArray,
        motion_time_s: FloatArray,
        session: Session,
        names: tuple[str, ...],
    ) -> ImuRecording:
        """Record true signals by the sensor of a segment.

        Parameters
        ----------
        segment : str
            Which sensor.
        rate, force : ndarray, shape (N, 3)
            Angular rate and specific force, rad/s and m/s^2, in the sensor's frame.
        motion_time_s : ndarray, shape (N,)
            Clock of the motion.
        session : Session
            Errors of the sensors.
        names : tuple of str
            As for `record`.

        Returns
        -------
        ImuRecording
            On the recording's clock.
        """
        keep, every = self.kept(motion_time_s), self.every
        time_s = motion_time_s[keep]
        if self.ideal:
            return ImuRecording(segment, time_s, rate[keep], force[keep])
        rng = stream(self.seed, *names, segment, "sensor")
        # the sensor also runs during the margin, where its filter settles, except for the outermost
        # samples, which have no derivatives
        inner = slice(every * EDGE, -every * EDGE)
        first = keep.start // every - EDGE
        readings = [
            measure(
                true[inner], every * self.sampling_rate_hz, every, model, errors,
                self.sensor.bandwidth_hz, self.sensor.bits, rng,
            )[first : first + len(time_s)]
            for true, model, errors in (
                (rate, self.sensor.gyroscope, session.gyroscopes[segment]),
                (force, self.sensor.accelerometer, session.accelerometers[segment]),
            )
        ]  # fmt: skip
        return ImuRecording(segment, time_s, *readings)
