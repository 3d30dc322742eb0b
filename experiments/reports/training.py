"""Output of a training besides its checkpoint: results on the training trials."""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.experiments.reports.networks import about_network
from narx.experiments.tables.table import Table
from narx.inference.checkpoint import Checkpoint
from narx.kinematics.segment_angles import AXES

# length of the piece of each joint: enough to show strides and errors
_PIECE_S = 20.0
_PIECE_RATE_HZ = 25.0
ANGLE_COLUMNS = ("trial", "segment", "axis", "method", "time_s", "reference_deg", "estimate_deg")


def training_summary(fold: str, network: Checkpoint, results: pd.DataFrame, skip_s: float) -> str:
    """Summarise a training.

    Parameters
    ----------
    fold : str
        Name of the training data.
    network : Checkpoint
        Trained network.
    results : pandas.DataFrame
        Columns of ``results.csv``, for the training trials.
    skip_s : float
        Start of each trial that is not scored, s.

    Returns
    -------
    str
        Markdown: starts and held-out error, then the errors if there is a reference.
    """
    paragraphs = [f"# Training on {fold}", about_network(fold, network)]
    scored = results[results["n_samples"] > 0]
    if len(scored):
        mean = scored.groupby(["segment", "axis"], sort=False)["rmse_deg"].mean().unstack("axis")
        frame = mean.reindex(columns=[axis for axis in AXES if axis in mean])
        table = Table(
            "RMSE (°) on the training trials",
            frame,
            dict.fromkeys(map(str, frame.columns), 2),
            f"Whole trials without their first {skip_s:g} s. Use narx-benchmark for the error on "
            "other people.",
        )
        paragraphs.append(table.to_markdown().strip())
    else:
        paragraphs.append("The training trials have no reference to compare with.")
    return "\n\n".join(paragraphs) + "\n"


def pieces(evaluated: Iterable[Evaluated]) -> pd.DataFrame:
    """Cut a short piece from every joint, or segment if there is no joint.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Results of any number of trials.

    Returns
    -------
    pandas.DataFrame
        Columns `ANGLE_COLUMNS`, one row per sample, axis and method; angles in degrees.
    """
    evaluated = list(evaluated)
    joints = [one for one in evaluated if one.segment.startswith(("knee", "joint"))]
    tables = [table for one in joints or evaluated for table in _piece(one)]
    if not tables:
        return pd.DataFrame(columns=list(ANGLE_COLUMNS))
    return pd.concat(tables, ignore_index=True)


def _piece(one: Evaluated) -> Sequence[pd.DataFrame]:
    scored = one.time_s[one.scored]
    if not len(scored):
        return []
    thin = one.between(float(scored[0]), float(scored[0]) + _PIECE_S).decimated(_PIECE_RATE_HZ)
    return [
        pd.DataFrame(
            {
                "trial": "/".join((one.dataset, one.subject, one.condition, one.trial)),
                "segment": one.segment,
                "axis": axis,
                "method": method,
                "time_s": thin.time_s,
                "reference_deg": np.degrees(thin.reference_rad[:, k]).round(4),
                "estimate_deg": np.degrees(angles[:, k]).round(4),
            }
        )
        for method, angles in thin.estimates_rad.items()
        for k, axis in enumerate(AXES)
    ]
