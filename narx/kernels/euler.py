"""Sine, cosine and Euler kinematics, for scalars and vectors."""

from typing import Any

from narx.kernels.compiler import INNER, compiled
from narx.kernels.lanes import exact_cos, exact_sin, magnitude, nearest, where_less
from narx.kernels.limits import COS_FRONTAL_MIN

PI_HIGH, PI_LOW = 3.141592651605606, 1.984187159361081e-09  # short enough that k PI_HIGH is exact

S0, S1, S2, S3, S4, S5, S6, S7, S8 = (
    1.0,
    -0.16666666666666666,
    0.008333333333333186,
    -0.00019841269841208646,
    2.755731921122385e-06,
    -2.5052106889980286e-08,
    1.6058940845888463e-10,
    -7.643025635861999e-13,
    2.721564494332108e-15,
)
C0, C1, C2, C3, C4, C5, C6, C7, C8 = (
    1.0,
    -0.4999999999999997,
    0.04166666666666388,
    -0.0013888888888772943,
    2.4801587277405412e-05,
    -2.755731639003024e-07,
    2.087656178396356e-09,
    -1.1462900299216276e-11,
    4.608958672926802e-14,
)


@compiled(**INNER)
def sine_cosine(x: Any, exact: Any) -> Any:
    """Sine and cosine: the C library's if `exact` is given, else polynomials (error 3e-16).

    Least-squares polynomials on +-90 degrees after subtracting whole half turns; accurate up to a
    million turns.
    """
    if exact is not None:
        return exact_sin(x), exact_cos(x)
    k = nearest(x * 0.3183098861837907)
    r = (x - k * PI_HIGH) - k * PI_LOW
    odd = k - 2.0 * nearest(k * 0.5)
    sign = 1.0 - 2.0 * (odd * odd)
    u = r * r
    u2 = u * u
    u4 = u2 * u2
    s = ((S1 * u + S0) + (S3 * u + S2) * u2) + ((S5 * u + S4) + (S7 * u + S6) * u2 + S8 * u4) * u4
    c = ((C1 * u + C0) + (C3 * u + C2) * u2) + ((C5 * u + C4) + (C7 * u + C6) * u2 + C8 * u4) * u4
    return (sign * r) * s, sign * c


@compiled(**INNER)
def angle_rates(
    u_sagittal: Any, u_frontal: Any, u_transverse: Any, sagittal: Any, frontal: Any, exact: Any
) -> Any:
    """Rates of the three angles from the gyroscope, and their derivatives by the tilt.

    As `narx.kinematics.segment_angles.coupled_rates`, with a lower limit on the magnitude of the
    cosine of the frontal angle. Returns the three rates, then d/d(sagittal) of them, then
    d/d(frontal).
    """
    sin_s, cos_s = sine_cosine(sagittal, exact)
    sin_f, cos_f = sine_cosine(frontal, exact)
    size = magnitude(cos_f)
    zero = size - size
    least = zero + COS_FRONTAL_MIN
    # beyond the limit the cosine is a constant of the same sign
    held = where_less(cos_f, zero, zero - COS_FRONTAL_MIN, least)
    inverse = 1.0 / where_less(size, least, held, cos_f)
    slope = where_less(size, least, zero, sin_f)  # minus the derivative of the limited cosine
    across = u_transverse * cos_s - u_frontal * sin_s
    along = u_frontal * cos_s + u_transverse * sin_s
    heading = across * inverse
    heading_s = zero - along * inverse
    heading_f = heading * (slope * inverse)
    rate_s = u_sagittal - sin_f * heading
    return (
        (rate_s, along, heading),
        (zero - sin_f * heading_s, across, heading_s),
        (zero - cos_f * heading - sin_f * heading_f, zero, heading_f),
    )
