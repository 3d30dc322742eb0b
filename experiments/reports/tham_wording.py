"""Text on Tables 2 to 4 of Tham et al., generated from the results."""

import pandas as pd
from omegaconf import DictConfig

from narx.experiments.method_labels import method_label
from narx.experiments.reports.report import Section
from narx.kinematics.segment_angles import AXES

# an error above this is divergence
_RUNAWAY_DEG = 30.0


def about_components(count: int, where: str) -> str:
    """Describe how many components Fig. 3 shows.

    Parameters
    ----------
    count : int
        Major components up to 98 % of the power.
    where : str
        Source of the gyroscope.

    Returns
    -------
    str
        One sentence, with the paper's three for comparison.
    """
    return (
        f"Fig. 3: {count} components contain 98 % of the power of the sagittal gyroscope "
        f"({where}). The paper finds 3 and uses as many hidden neurons, as does "
        "`model.hidden=auto`."
    )


def differences_from_paper(cells: pd.DataFrame, cfg: DictConfig, simulated: bool) -> list[Section]:
    """Explain where and why the results differ from the paper.

    Parameters
    ----------
    cells : pandas.DataFrame
        From `narx.experiments.tables.tham.comparison_with_published`.
    cfg : omegaconf.DictConfig
        The benchmark's configuration.
    simulated : bool
        Whether the walkers are simulated.

    Returns
    -------
    list of str
        Paragraphs.
    """
    paragraphs: list[Section] = ["**Where and why these results differ from the paper.**"]
    rmse = cells.pivot_table(index=["axis", "condition"], columns="method", values="rmse_deg")
    rmse = rmse.reindex([key for key in rmse.index if key[0] in AXES])
    if "narx" in rmse and rmse.shape[1] > 1:
        paragraphs.append(_about_narx(rmse, cells, cfg))
    known = cells[cells["method"] == "pseudo_integrator"]
    if len(known):
        paragraphs.append(_about_pseudo_integrator(known))
    known = cells[cells["method"] == "complementary_filter"]
    if len(known):
        paragraphs.append(_about_complementary_filter(known))
    if "gyro_integration" in rmse and rmse["gyro_integration"].max() > _RUNAWAY_DEG:
        paragraphs.append(
            "Plain integration, which the paper does not tabulate, diverged (RMSE up to "
            f"{rmse['gyro_integration'].max():.0f}°): three independent integrals drift even "
            "without any bias, and knee angles are principal values, so the error of an "
            "arbitrary orientation is near 100° and does not grow further."
        )
    if simulated:
        paragraphs.append(_ABOUT_SIMULATION)
    return paragraphs


def _about_narx(rmse: pd.DataFrame, cells: pd.DataFrame, cfg: DictConfig) -> str:
    others = [str(name) for name in rmse.columns if name != "narx"]
    best = int((rmse["narx"] < rmse[others].min(axis=1)).sum())
    lines = [f"NARX has the lowest RMSE in {best} of {len(rmse)} planes and speeds (paper: all 9)."]
    for name in others:
        lower = [" ".join(map(str, key)) for key in rmse.index[rmse[name] < rmse["narx"]]]
        if lower:
            lines.append(f"{method_label(name)} has a lower RMSE in {', '.join(lower)}.")
    mine = cells[(cells["method"] == "narx") & cells["paper rmse_deg"].notna()]
    if len(mine):
        below = int((mine["rmse_deg"] < mine["paper rmse_deg"]).sum())
        lines.append(f"NARX's RMSE is below the published one in {below} of {len(mine)}.")
    if cfg.model.odd and cfg.model.coupled:
        lines.append(
            "This is not the network of the paper: it is an odd function, its input rates are "
            "coupled by the estimated tilt, and it starts from an estimated posture "
            "(docs/methods). `model=tham_literal` is the network of the paper."
        )
    else:
        lines.append("`model=coupled` is the package's own network.")
    return " ".join(lines)


def _about_pseudo_integrator(mine: pd.DataFrame) -> str:
    bias = mine.groupby("axis")["bias_deg"].mean()
    precision = mine.groupby("axis")["precision_deg"].mean()
    figures = ", ".join(
        f"{axis} {bias[axis]:+.1f} ± {precision[axis]:.1f}°" for axis in AXES if axis in bias
    )
    return (
        "PI has zero gain at zero frequency: the mean of every angle is zero, so the mean knee "
        f"angle appears as bias (bias ± precision over speeds: {figures}). The paper reports at "
        "most 4.8° of bias and does not explain how the mean was recovered; its precision is "
        "comparable."
    )


def _about_complementary_filter(mine: pd.DataFrame) -> str:
    frontal = mine[mine["axis"] == "frontal"]
    return (
        "CF does not estimate the transverse angle. Its frontal correlation is "
        f"{frontal['r'].min():.2f} to {frontal['r'].max():.2f} (paper: 0.94 to 0.96): it "
        "treats the axes independently, and only the accelerometer corrects the effect of rotation "
        "about the other two axes on a tilted segment."
    )


_ABOUT_SIMULATION = (
    "The walkers are simulated (docs/simulator.md): heights and masses of Table 1, joint angles "
    "from normative curves, sensors and markers on moving soft tissue, "
    "functional calibration with its errors. The range of motion of the knee in the frontal and "
    "transverse planes is small compared with these errors, so correlations are lowest there. "
    "docs/experiments.md has the results without these errors."
)
