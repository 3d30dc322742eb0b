"""Test for differences between estimate and reference over the gait cycle (SPM1D)."""

from dataclasses import dataclass

import numpy as np

from narx.types import FloatArray


@dataclass(frozen=True)
class WaveformTest:
    """Paired t-test over the whole cycle by statistical parametric mapping (Pataky 2010).

    Parameters
    ----------
    n_subjects : int
        Pairs of mean waveforms.
    threshold : float
        Critical |t| over the whole cycle.
    clusters : tuple of (float, float, float)
        Parts of the cycle with a difference: begin and end in %, p-value.
    share_percent : float
        Share of the cycle in those parts, %.
    largest_difference_deg : float
        Largest absolute mean difference anywhere in the cycle, degrees.
    """

    n_subjects: int
    threshold: float
    clusters: tuple[tuple[float, float, float], ...]
    share_percent: float
    largest_difference_deg: float


def waveform_test(
    reference_deg: FloatArray, estimate_deg: FloatArray, alpha: float = 0.05
) -> WaveformTest | None:
    """Test two sets of mean waveforms against each other, subject by subject.

    Parameters
    ----------
    reference_deg, estimate_deg : ndarray, shape (subjects, points)
        Mean over the strides of each subject, 0-100 % of the cycle, degrees.
    alpha : float
        Two-sided level for the whole cycle.

    Returns
    -------
    WaveformTest or None
        None with fewer than three subjects or where the differences do not vary, for which the
        test is not defined.
    """
    difference = np.asarray(reference_deg, float) - np.asarray(estimate_deg, float)
    n_subjects = len(difference)
    if n_subjects < 3 or not np.all(difference.std(axis=0) > 1e-9):
        return None
    import spm1d  # slow to import, and needed only for tables

    # paired by subject: one sample of differences against zero
    found = spm1d.stats.ttest(difference).inference(alpha, two_tailed=True)
    last = difference.shape[1] - 1
    clusters = tuple(
        (100.0 * begin / last, 100.0 * end / last, float(cluster.P))
        for cluster in found.clusters
        for begin, end in [sorted(map(float, cluster.endpoints))]
    )
    return WaveformTest(
        n_subjects,
        float(found.zstar),
        clusters,
        sum(end - begin for begin, end, _ in clusters),
        float(np.abs(difference.mean(axis=0)).max()),
    )
