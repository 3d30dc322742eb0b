"""Cost of the methods: operations per sample and angle, counted while they run."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.baselines.giof import Giof
from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.operation_count import operation_table
from narx.baselines.pseudo_integrator import PseudoIntegrator
from narx.baselines.two_point import TwoPoint
from narx.method import OrientationMethod, SegmentSignals
from narx.types import BoolArray

# As counted in the papers: the bare recursions, by the papers' rules and for one angle if possible;
# the low-pass filter of real-time GIOF is a separate row.
_COUNTED: Mapping[str, OrientationMethod] = MappingProxyType(
    {
        "giof": Giof(mode="real_time", axes=("sagittal",), low_pass_hz=None),
        "giof_real_time": Giof(mode="real_time", axes=("sagittal",)),
        "complementary_filter": ComplementaryFilter(rule="rectangle", axes=("sagittal",)),
        "gyro_integration": GyroIntegration(rule="rectangle"),
        "pseudo_integrator": PseudoIntegrator(gait_frequency_hz=1.0),
        "two_point": TwoPoint(),
    }
)
# counting runs in plain Python; a few strides represent a walk
_LONGEST_S = 5.0


def operations_per_angle(signals: SegmentSignals) -> dict[str, dict[str, float]]:
    """Count the operations of every method that can be counted, over one walk.

    Parameters
    ----------
    signals : SegmentSignals
        A walk; samples with missing values are left out, and all after the first seconds.

    Returns
    -------
    dict of str to dict of str to float
        By method and operation, mean per sample and angle.
    """
    six = np.hstack([signals.axis_rates_rad_s, signals.specific_force_m_s2])
    valid: BoolArray = np.asarray(np.isfinite(six).all(axis=1))
    valid[np.flatnonzero(valid)[round(_LONGEST_S * signals.sampling_rate_hz) :]] = False
    walk = signals.select(valid)
    counts: dict[str, dict[str, float]] = {}
    for name, row in operation_table(walk, _COUNTED).iterrows():
        method = _COUNTED[str(name)]
        # 2-point is counted for one angle already
        together = 1
        if not isinstance(method, TwoPoint):
            together = int(np.isfinite(method.estimate(walk)).any(axis=0).sum())
        counts[str(name)] = {str(kind): float(n) / together for kind, n in row.items()}
    return counts
