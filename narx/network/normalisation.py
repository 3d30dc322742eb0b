"""Normalisation of rates and angles for the network, and its inverse."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from narx.types import FloatArray

Kind = Literal["min_max", "max_abs", "std"]


@dataclass(frozen=True)
class Normalisation:
    """Affine map of rates and angles; ``normalised = (value - offset) / scale``.

    Parameters
    ----------
    rate_scale_rad_s : float
        Scale of the angular rate.
    angle_scale_rad : float
        Scale of the angle.
    rate_offset_rad_s : float
        Offset of the angular rate; zero keeps an odd network odd.
    angle_offset_rad : float
        Offset of the angle.
    rate_rms_rad_s : float
        Root mean square of the training rate, the reference for the amplitude of other axes.
    """

    rate_scale_rad_s: float
    angle_scale_rad: float
    rate_offset_rad_s: float = 0.0
    angle_offset_rad: float = 0.0
    rate_rms_rad_s: float = 1.0

    @classmethod
    def fit(cls, rates_rad_s: FloatArray, angles_rad: FloatArray, kind: Kind) -> "Normalisation":
        """Choose offset and scale from training data.

        Parameters
        ----------
        rates_rad_s : ndarray
            Angular rates of the trained axis; NaN is ignored.
        angles_rad : ndarray
            Angles of the trained axis; NaN is ignored.
        kind : {"min_max", "max_abs", "std"}
            ``min_max`` maps the range onto -1..1 (what 'normalized' means in the neural network
            toolbox that Tham et al. used); ``max_abs`` and ``std`` only scale, so that zero maps to
            zero.

        Returns
        -------
        Normalisation
            The map.

        Raises
        ------
        ValueError
            If the kind is unknown or a signal does not vary.
        """
        if kind not in get_args(Kind):
            raise ValueError(f"normalisation '{kind}' is none of {', '.join(get_args(Kind))}")
        rate_offset, rate_scale = _offset_and_scale(rates_rad_s, kind)
        angle_offset, angle_scale = _offset_and_scale(angles_rad, kind)
        rate_rms = float(np.sqrt(np.nanmean(np.square(rates_rad_s))))
        return cls(rate_scale, angle_scale, rate_offset, angle_offset, rate_rms)


def _offset_and_scale(values: FloatArray, kind: Kind) -> tuple[float, float]:
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if values.size == 0 or np.ptp(values) == 0:
        raise ValueError("a signal that does not vary cannot be normalised")
    if kind == "min_max":
        return float(values.max() + values.min()) / 2, float(np.ptp(values)) / 2
    if kind == "max_abs":
        return 0.0, float(np.abs(values).max())
    return 0.0, float(np.std(values))
