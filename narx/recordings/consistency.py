"""Consistency of the rotations measured by gyroscope and accelerometer.

Under pure rotation the specific force obeys df/dt = -w x f in the sensor frame. In walking there is
acceleration as well, so the relation holds only approximately: below 1.5 Hz the slope of df/dt on
-w x f is 0.35 to 0.9 on ten recorded thighs and shanks. That is enough to detect a wrong unit (a
factor of 57) or a mirrored frame; where the relation holds closely, each axis and the scale are
checked as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt

from narx.types import FloatArray

_LOW_PASS_HZ = 1.5
_MOVING_RAD_S = 0.35
_MIN_MOVING_S = 3.0
# unit errors give slopes outside these limits; those of recorded walks are well inside
_SLOPES = (0.08, 5.0)
_MIN_CORRELATION = 0.25
# In walking, accelerations can outweigh the turning of gravity: 16 of 216 pieces of simulated walks
# look reversed, with correlations down to -0.38; a recording is refused only beyond this one.
_CERTAIN_CORRELATION = -0.45
# the relation holds closely: check the scale and the sign of each axis
_CLOSE_R2 = 0.8
_SCALES = (0.7, 1.4)
# ratio of the unexplained variances in the file's order of axes and in the best one
_EXCHANGED = 2.5
_REVERSED, _REVERSED_T = -0.3, -8.0


@dataclass(frozen=True)
class Fit:
    """Least-squares fit of df/dt on -w x f over the moving part.

    Parameters
    ----------
    slope, correlation : float
        Fit of all axes together.
    axes : ndarray, shape (3,)
        Slope of each gyroscope axis, fitted together.
    t : ndarray, shape (3,)
        The slopes over their standard errors, with the filter's degrees of freedom.
    r2 : float
        Share of the variance that the three slopes explain.
    order : str
        Order of the gyroscope's axes that explains most: ``xyz`` unless some are swapped.
    r2_of_order : float
        Share explained in this order.
    """

    slope: float
    correlation: float
    axes: FloatArray
    t: FloatArray
    r2: float
    order: str
    r2_of_order: float


def fit_rotation(
    gyroscope_rad_s: FloatArray, accelerometer_m_s2: FloatArray, sampling_rate_hz: float
) -> Fit | None:
    """Compare the gyroscope with the rotation measured by the accelerometer.

    Parameters
    ----------
    gyroscope_rad_s, accelerometer_m_s2 : ndarray, shape (N, 3)
        On one uniform clock, sensor frame, gyroscope without bias; rows with NaN are left out.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    Fit or None
        None with less than three seconds of movement.
    """
    valid = np.isfinite(gyroscope_rad_s).all(axis=1) & np.isfinite(accelerometer_m_s2).all(axis=1)
    rate, force = gyroscope_rad_s[valid], accelerometer_m_s2[valid]
    if len(rate) < _MIN_MOVING_S * sampling_rate_hz or sampling_rate_hz <= 4 * _LOW_PASS_HZ:
        return None
    low_pass = butter(2, _LOW_PASS_HZ, fs=sampling_rate_hz, output="sos")
    slow_force = sosfiltfilt(low_pass, force, axis=0)
    slow_rate = sosfiltfilt(low_pass, rate, axis=0)
    change = np.gradient(slow_force, axis=0) * sampling_rate_hz
    # movement according to either sensor: the gyroscope's unit may be wrong
    turning = np.sqrt((slow_rate**2).sum(axis=1))
    shaking = np.sqrt((change**2).sum(axis=1)) / max(
        1e-9, float(np.median(np.linalg.norm(force, axis=1)))
    )
    window = max(1, round(sampling_rate_hz))
    moving = np.maximum(uniform_filter1d(turning, window), uniform_filter1d(shaking, window))
    moving = moving > _MOVING_RAD_S
    if moving.sum() < _MIN_MOVING_S * sampling_rate_hz or not np.any(slow_rate[moving]):
        return None
    y = change[moving].ravel()
    products = _products(slow_rate[moving], slow_force[moving])
    x = products[:, _columns_of(range(3))]
    together = x.sum(axis=1)
    power = float(together @ together)
    normal = x.T @ x
    if power == 0 or not np.any(y) or np.linalg.cond(normal) > 1e12:
        return None
    axes = np.linalg.solve(normal, x.T @ y)
    residual = y - x @ axes
    freedom = 2 * _LOW_PASS_HZ * 3 * moving.sum() / sampling_rate_hz
    variance = max(residual.var(), 1e-12 * y.var()) * len(y) / freedom
    orders = {}
    gram, with_y, means = products.T @ products, products.T @ y, products.mean(axis=0)
    for order in permutations(range(3)):
        own = _columns_of(order)
        slopes = np.linalg.lstsq(gram[np.ix_(own, own)], with_y[own])[0]
        # variance of y - x slopes, from the sums above
        left = (y @ y - slopes @ with_y[own]) / len(y) - (y.mean() - slopes @ means[own]) ** 2
        orders["".join("xyz"[k] for k in order)] = float(1.0 - left / y.var())
    best = max(orders, key=lambda order: orders[order])
    return Fit(
        float(together @ y) / power,
        float(together @ y) / float(np.sqrt(power * (y @ y))),
        axes,
        axes / np.sqrt(variance * np.diag(np.linalg.inv(normal))),
        float(1.0 - residual.var() / y.var()),
        best,
        orders[best],
    )


def is_certain(fit: Fit) -> bool:
    """Decide whether a contradiction cannot be explained by the accelerations of walking.

    Parameters
    ----------
    fit : Fit
        From `fit_rotation`, with a `contradiction`.

    Returns
    -------
    bool
        True for another unit, for a relation that holds closely, and for a clearly negative
        correlation.
    """
    return _other_unit(fit) or fit.r2_of_order > _CLOSE_R2 or fit.correlation < _CERTAIN_CORRELATION


def _other_unit(fit: Fit) -> bool:
    related = abs(fit.correlation) >= _MIN_CORRELATION
    return related and not _SLOPES[0] < abs(fit.slope) < _SLOPES[1]


def _products(rate: FloatArray, force: FloatArray) -> FloatArray:
    """Change of the specific force if column k of the rates were the rate about axis p: 3 k + p."""
    about = [-np.cross(np.eye(3)[p], force) for p in range(3)]
    return np.stack([(rate[:, k, None] * a).ravel() for k in range(3) for a in about], axis=1)


def _columns_of(order: Sequence[int]) -> list[int]:
    return [3 * k + p for p, k in enumerate(order)]


def contradiction(fit: Fit) -> str | None:
    """Describe how a gyroscope contradicts its accelerometer.

    Parameters
    ----------
    fit : Fit
        From `fit_rotation`.

    Returns
    -------
    str or None
        The contradiction and its likely cause; None if there is none.
    """
    if fit.r2_of_order > _CLOSE_R2 and 1.0 - fit.r2 > _EXCHANGED * (1.0 - fit.r2_of_order):
        return (
            f"the accelerometer fits the gyroscope's axes in the order {fit.order}: columns are "
            "exchanged"
        )
    if _other_unit(fit):
        factor = 1.0 / abs(fit.slope)
        guess = ""
        if 20 < factor < 200:
            guess = "; deg/s in a column of rad/s?"
        elif 1 / 200 < factor < 1 / 20:
            guess = "; rad/s in a column of deg/s?"
        return f"the gyroscope turns {factor:.3g} times as fast as the accelerometer shows{guess}"
    if fit.correlation <= -_MIN_CORRELATION:
        return (
            "the gyroscope turns the other way than the accelerometer shows (slope "
            f"{fit.slope:.2f}): a mirrored frame, or the sign of the gyroscope"
        )
    reversed_axes = [
        name
        for name, slope, t in zip("xyz", fit.axes, fit.t, strict=True)
        if slope < _REVERSED and t < _REVERSED_T
    ]
    if reversed_axes:
        return (
            f"gyroscope {' and '.join(reversed_axes)} turns the other way than the accelerometer "
            "shows: a mirrored axis, or its sign"
        )
    if fit.r2 > _CLOSE_R2 and not _SCALES[0] < fit.slope < _SCALES[1]:
        return (
            f"the gyroscope turns {1 / fit.slope:.2g} times as fast as the accelerometer shows: "
            "its scale is wrong"
        )
    return None
