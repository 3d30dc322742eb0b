"""The training of Tham et al. as printed: spread over draws, compared with variants."""

import pandas as pd

from narx.experiments.published import published
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES

# a training with a larger closed-loop error on its own window has failed, deg
FAILED_DEG = 10.0


def as_printed_table(results: pd.DataFrame) -> Table:
    """Summarise the draws of every variant.

    Parameters
    ----------
    results : pandas.DataFrame
        One row per variant and draw: ``variant``, ``draw``, ``neurons``, ``one_step_deg``,
        ``closed_loop_deg`` and ``knee_sagittal_deg`` and so on.

    Returns
    -------
    Table
        One row per variant with median and quartiles over draws, and the published values below.
    """
    columns = {
        "one_step_deg": "one step ahead",
        "closed_loop_deg": "closed loop, own window",
        **{f"knee_{axis}_deg": f"knee {axis}" for axis in AXES},
    }
    printed = published("tham_tables_2_to_4")
    printed = printed[(printed["condition"] == "normal") & (printed["method"] == "narx")]
    rmse = printed.set_index("axis")["rmse_mean_deg"]
    shown: list[dict[str, str]] = []
    for variant, draws in results.groupby("variant", sort=False):
        errors = draws[[f"knee_{axis}_deg" for axis in AXES]].to_numpy()
        reproduced = int((errors <= rmse[list(AXES)].to_numpy()).all(axis=1).sum())
        failed = int((draws["closed_loop_deg"] > FAILED_DEG).sum())
        shown.append(
            {"Variant": str(variant)}
            | {
                title: _spread(draws[name], 3 if name == "one_step_deg" else 1)
                for name, title in columns.items()
            }
            | {
                f"own window beyond {FAILED_DEG:g}°": f"{failed} of {len(draws)}",
                "knee as good as print": f"{reproduced} of {len(draws)}",
            }
        )
    shown.append(
        {"Variant": "Tham et al."} | {f"knee {axis}": f"{rmse[axis]:.1f}" for axis in AXES}
    )
    neurons = results.drop_duplicates("draw")["neurons"].value_counts().sort_index()
    counts = ", ".join(f"{number} in {count}" for number, count in neurons.items())
    return Table(
        "Tham et al. trained as printed: RMSE (°) at normal speed, median [quartiles] over draws",
        pd.DataFrame(shown).set_index("Variant"),
        note=f"{results['draw'].nunique()} draws of segment, window and start; every variant "
        "changes one thing of the first and has the same draws. Own window: against the target "
        f"learnt. Knee: all walks, against the reference; as good as print in all three planes. "
        f"Neurons by the 98 % rule: {counts} draws; print has 3.",
    )


def _spread(values: pd.Series, decimals: int) -> str:
    low, middle, high = values.quantile([0.25, 0.5, 0.75])
    return f"{middle:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"
