"""Strapdown integration: orientation from all three axes of the gyroscope."""

from narx.kernels.strapdown import compose_turns
from narx.kinematics.segment_angles import gyroscope_xyz, orientation_from_angles
from narx.types import FloatArray


def strapdown_orientation(
    mean_rates_rad_s: FloatArray, interval_s: float, initial_angles_rad: FloatArray
) -> FloatArray:
    """Compose the rotations of a segment from one sample to the next.

    Parameters
    ----------
    mean_rates_rad_s : ndarray, shape (N, 3)
        Mean rates between neighbouring samples about the clinical axes
        (`narx.kinematics.segment_angles.axis_rates`), rad/s.
    interval_s : float
        Sampling interval, s.
    initial_angles_rad : ndarray, shape (3,)
        Sagittal, frontal and transverse angle at the first sample, rad.

    Returns
    -------
    ndarray, shape (N + 1, 4)
        Quaternions w, x, y, z of the anatomical frame, the first from the initial angles.
    """
    start = orientation_from_angles(initial_angles_rad)[0]
    return compose_turns(start, gyroscope_xyz(mean_rates_rad_s) * interval_s)
