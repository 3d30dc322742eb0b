"""Training by Levenberg-Marquardt: many starts, a curriculum, the best by held-back samples."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor

from narx.errors import UserError
from narx.network.cell import coupled_rates
from narx.network.model import Narx
from narx.training.batch import Batch
from narx.training.initial_weights import leaky_integrator_weights, random_weights, typical_sizes
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.coupled import CoupledFit
from narx.training.least_squares.damping import Damping
from narx.training.least_squares.problem import LeastSquaresProblem, TowardsPrior
from narx.training.least_squares.solver import Options
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import Stage, multi_start
from narx.training.objective import FitReport, Log, Objective


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Levenberg-Marquardt with exact sensitivities.

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Evaluations per start and stage.
    curriculum : sequence of {"open", int, "closed"}
        Stages: one step ahead, so many samples ahead, or the whole sequence in closed loop.
        Before the closed loop, coupled axes take the tilt from the teacher.
    prior_deg2 : float
        How much mean squared error, in deg^2, it is worth to change a weight of the leaky
        integrator by all its size; 0 for no prior.
    cost_change : float
        A start stops when a step lowers its cost by less than this share.
    bayesian : bool
        Bayesian regularisation (`narx.training.least_squares.solver.Options`) instead of the prior.
    """

    restarts: int = 16
    iterations: int = 100
    curriculum: Sequence[str | int] = field(default=("closed",))
    prior_deg2: float = 1.0
    cost_change: float = 1e-6
    bayesian: bool = False

    def fit(
        self,
        model: Narx,
        training: Batch,
        validation: Batch,
        objective: Objective,
        rng: np.random.Generator,
        log: Log,
    ) -> FitReport:
        """Set the weights of a network to the best found.

        Parameters
        ----------
        model : Narx
            Network.
        training, validation : Batch
            Sequences; the second chooses among starts.
        objective : Objective
            What is minimised. Only the closed loop of coupled axes takes mean errors off; else
            the targets have lost their mean already.
        rng : numpy.random.Generator
            Draws the starts.
        log : callable
            Told cost, damping and gradient of every iteration of the kept start.

        Returns
        -------
        FitReport
            History of the kept start and the spread of all.

        Raises
        ------
        UserError
            If the curriculum has an unknown stage, or no start stays finite.
        """
        options = Options(
            Stopping(max_evaluations=self.iterations, cost_change=self.cost_change),
            # first and second layer differ in size by orders of magnitude
            Damping(scaling="diagonal"),
            bayesian=self.bayesian,
        )
        centre = leaky_integrator_weights(model)
        size = typical_sizes(model)
        stages = []
        for number, name in enumerate(self.curriculum):
            problem = _problem(name, model, training, objective)
            strength = self.prior_deg2 * problem.n_residuals / _squared_degrees(name, model)
            if strength > 0 and not self.bayesian:
                problem = TowardsPrior(problem, centre, strength / size**2)
            stages.append(Stage(f"{number} {name}", problem, options))
        starts = np.array([random_weights(model, rng) for _ in range(self.restarts)])
        chosen_by = _problem("closed", model, validation, objective)
        result = multi_start(stages, starts, chosen_by, trainable=model.trainable.numpy())
        with torch.no_grad():
            model.weights.copy_(torch.from_numpy(result.weights))
        history = result.history()
        for iteration, numbers in enumerate(history):
            log(iteration, numbers)
        spread = result.spread()
        to_degrees = _squared_degrees("closed", model) ** 0.5
        last = list(result.stages.values())[-1]
        codes = [code for group in last for code in group.codes]
        return FitReport(
            str(codes[result.best]),
            len(history),
            history,
            {
                "restarts": spread["n_starts"],
                "dropped": spread["n_dropped"],
                "validation_rmse_best_deg": spread["min"] * to_degrees,
                "validation_rmse_median_deg": spread["median"] * to_degrees,
                "validation_rmse_worst_deg": spread["max"] * to_degrees,
            },
        )


def _problem(
    name: str | int, model: Narx, sequences: Batch, objective: Objective
) -> LeastSquaresProblem:
    """Choose the fit of a stage."""
    horizon = {"open": 1, "closed": None}.get(name, name) if isinstance(name, str) else name
    if isinstance(horizon, str) or horizon == 0:
        raise UserError(f"optimizer.curriculum holds '{name}', expected open, closed or a number")
    washout = objective.washout_samples(model)
    if model.coupled and horizon is None:
        one = torch.ones(3, dtype=torch.float64)
        return CoupledFit(
            sequences.rates_rad_s,
            sequences.targets_rad,
            sequences.state,
            sequences.posture_rad,
            rate_scale=one * model.normalisation.rate_scale_rad_s,
            angle_scale=one * model.normalisation.angle_scale_rad,
            structure=model.structure,
            axis_weights=objective.axis_weights,
            sequence_weights=sequences.weight,
            washout=washout,
            offset_free=objective.offset_free,
        )
    inputs, targets = _normalised(model, sequences)
    axes = [axis for axis, weight in enumerate(objective.axis_weights) if weight > 0]
    weights = torch.tensor([objective.axis_weights[axis] for axis in axes], dtype=torch.float64)
    return NetworkFit(
        inputs[:, axes],
        targets[:, axes],
        sequences.state[:, axes],
        structure=model.structure,
        sequence_weights=sequences.weight[:, None] * weights,
        washout=washout,
        horizon=horizon,
    )


def _normalised(model: Narx, sequences: Batch) -> tuple[Tensor, Tensor]:
    """Inputs (B, 3, N, 1) and targets (B, 3, N) of each axis on its own."""
    scaled = model.normalisation
    rates = sequences.rates_rad_s
    if model.coupled:
        rates = coupled_rates(rates, sequences.targets_rad.nan_to_num())
    inputs = (rates - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s
    deviation = sequences.targets_rad - sequences.posture_rad[:, None]
    targets = (deviation - scaled.angle_offset_rad) / scaled.angle_scale_rad
    return inputs.transpose(1, 2).unsqueeze(-1), targets.transpose(1, 2)


def _squared_degrees(name: str | int, model: Narx) -> float:
    """Square degrees in the unit of a problem's squared residuals."""
    unit_rad = 1.0 if model.coupled and name == "closed" else model.normalisation.angle_scale_rad
    return float(np.rad2deg(unit_rad)) ** 2
