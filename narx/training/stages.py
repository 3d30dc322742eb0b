"""The stages that every optimiser minimises: one step ahead, several steps, closed loop."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from narx.errors import UserError
from narx.network.cell import coupled_rates
from narx.network.model import Narx
from narx.training.batch import Batch
from narx.training.initial_weights import leaky_integrator_weights, typical_sizes
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.coupled import CoupledFit
from narx.training.least_squares.one_step import OneStepFit
from narx.training.least_squares.problem import LeastSquaresProblem, TowardsPrior
from narx.training.objective import Objective
from narx.windows.lagged import LaggedWindows


@dataclass(frozen=True)
class Stage:
    """One problem of a curriculum.

    Parameters
    ----------
    name : str
        Name of the stage, for reports.
    problem : LeastSquaresProblem
        Problem to minimise.
    mean_square : float
        Factor that makes the sum of its squares a mean square; in deg^2 for a network's stages.
    """

    name: str
    problem: LeastSquaresProblem
    mean_square: float


def stages_of(
    model: Narx,
    training: Batch,
    objective: Objective,
    curriculum: Sequence[str | int],
    prior_deg2: float,
) -> list[Stage]:
    """Build the problems of a curriculum.

    Parameters
    ----------
    model : Narx
        Network.
    training : Batch
        Sequences, including the artificial return to rest.
    objective : Objective
        Weights and washout. Mean errors are subtracted only in the closed loop of coupled axes; one
        and several steps ahead, the targets already have zero mean.
    curriculum : sequence of {"open", int, "closed"}
        Stages: one step ahead (on lagged windows), a number of samples ahead, or the whole sequence
        in closed loop. Before the closed loop, coupled axes use the tilt of the teacher.
    prior_deg2 : float
        Mean squared error, in deg^2, equivalent to a change of a weight of the leaky integrator by
        100 %; 0 for no prior.

    Returns
    -------
    list of Stage
        Stages with costs in deg^2.

    Raises
    ------
    UserError
        If no sample of the training sequences is used.
    """
    centre, size = leaky_integrator_weights(model), typical_sizes(model)
    stages = []
    for number, name in enumerate(curriculum):
        if name == "closed":
            problem, unit_deg2 = closed_loop_fit(model, training, objective, "training")
        else:
            problem = _ahead(name, model, training, objective)
            unit_deg2 = float(np.rad2deg(model.normalisation.angle_scale_rad)) ** 2
            _refuse_nothing(problem, model, training, objective, "training")
        mean_square = unit_deg2 / problem.total_weight
        if prior_deg2 > 0:
            problem = TowardsPrior(problem, centre, prior_deg2 / mean_square / size**2)
        stages.append(Stage(f"{number} {name}", problem, mean_square))
    return stages


def closed_loop_fit(
    model: Narx, sequences: Batch, objective: Objective, what: str
) -> tuple[LeastSquaresProblem, float]:
    """Build the fit of whole sequences in closed loop.

    Parameters
    ----------
    model : Narx
        Network.
    sequences : Batch
        Training or held-out sequences.
    objective : Objective
        Axis weights, washout, and whether mean errors are removed.
    what : str
        Kind of the sequences, for the message.

    Returns
    -------
    problem : LeastSquaresProblem
        Residuals in rad (coupled axes) or in normalised units.
    unit_deg2 : float
        Square degrees per unit of its squared residuals.

    Raises
    ------
    UserError
        If no sample is scored, so that any network would have an error of zero; or if mean errors
        are to be removed and the axes are not coupled.
    """
    objective = objective.for_axes(model.coupled)
    washout = objective.washout_samples(model)
    scaled = model.normalisation
    if model.coupled:
        one = torch.ones(3, dtype=torch.float64)
        problem: LeastSquaresProblem = CoupledFit(
            sequences.rates_rad_s,
            sequences.targets_rad,
            sequences.state,
            sequences.posture_rad,
            rate_scale=one * scaled.rate_scale_rad_s,
            angle_scale=one * scaled.angle_scale_rad,
            structure=model.structure,
            axis_weights=objective.axis_weights,
            sequence_weights=sequences.weight,
            washout=washout,
            offset_free=bool(objective.offset_free),
        )
    else:
        problem = _axes_fit(model, sequences, objective, None)
    _refuse_nothing(problem, model, sequences, objective, what)
    unit_rad = 1.0 if model.coupled else scaled.angle_scale_rad
    return problem, float(np.rad2deg(unit_rad)) ** 2


def _refuse_nothing(
    problem: LeastSquaresProblem, model: Narx, sequences: Batch, objective: Objective, what: str
) -> None:
    if problem.total_weight > 0:
        return
    longest_s = sequences.rates_rad_s.shape[1] / model.sampling_rate_hz
    raise UserError(
        f"training: no sample of the {what} sequences counts; the longest lasts {longest_s:.1f} s, "
        f"model.objective.washout_s is {objective.washout_s:g} s, axis_weights are "
        f"{list(objective.axis_weights)}, and targets that are missing do not count"
    )


def _ahead(
    name: str | int, model: Narx, sequences: Batch, objective: Objective
) -> LeastSquaresProblem:
    """Choose the fit of a stage before the closed loop."""
    if name != "open":
        return _axes_fit(model, sequences, objective, int(name))
    # the first scored windows use earlier samples, possibly within the washout
    first = max(model.structure.input_lags - 1, model.structure.output_lags)
    begin = max(objective.washout_samples(model) - first, 0)
    windows = LaggedWindows.of_arrays(
        model,
        list(sequences.rates_rad_s[:, begin:].numpy()),
        list(sequences.targets_rad[:, begin:].numpy()),
        list(sequences.posture_rad.numpy()),
        sequences.weight.tolist(),
        objective.axis_weights,
    )
    return OneStepFit(windows, model.structure)


def _axes_fit(
    model: Narx, sequences: Batch, objective: Objective, horizon: int | None
) -> LeastSquaresProblem:
    """Fit each axis independently, a number of samples ahead or in closed loop."""
    scaled, rates = model.normalisation, sequences.rates_rad_s
    if model.coupled:
        rates = coupled_rates(rates, sequences.targets_rad.nan_to_num())
    inputs = (rates - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s
    deviation = sequences.targets_rad - sequences.posture_rad[:, None]
    targets = (deviation - scaled.angle_offset_rad) / scaled.angle_scale_rad
    axes = [axis for axis, weight in enumerate(objective.axis_weights) if weight > 0]
    weights = torch.tensor([objective.axis_weights[axis] for axis in axes], dtype=torch.float64)
    return NetworkFit(
        inputs.transpose(1, 2).unsqueeze(-1)[:, axes],
        targets.transpose(1, 2)[:, axes],
        sequences.state[:, axes],
        structure=model.structure,
        sequence_weights=sequences.weight[:, None] * weights,
        washout=objective.washout_samples(model),
        horizon=horizon,
    )
