"""True motion of a simulated trial, free of measurement errors."""

from dataclasses import dataclass

from narx.types import FloatArray


@dataclass(frozen=True)
class TrueMotion:
    """True motion of a trial.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        The trial's clock.
    joint_angles : dict of str to ndarray, shape (N, 3)
        ``pelvis``, ``hip_right``, ``knee_right``, ``hip_left``, ``knee_left`` in rad: flexion,
        abduction, internal rotation.
    segment_wxyz : dict of str to ndarray, shape (N, 4)
        Bone to global, for every segment.
    sensor_wxyz : dict of str to ndarray, shape (N, 4)
        Sensor to global, for every segment with an IMU.
    sensor_position_m : dict of str to ndarray, shape (N, 3)
        Position of the sensor in the global frame.
    speed_m_s : float
        Walking speed.
    """

    time_s: FloatArray
    joint_angles: dict[str, FloatArray]
    segment_wxyz: dict[str, FloatArray]
    sensor_wxyz: dict[str, FloatArray]
    sensor_position_m: dict[str, FloatArray]
    speed_m_s: float
