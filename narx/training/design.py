"""From stretches of training data to a trained network."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from narx.errors import UserError
from narx.gait.spectrum import hidden_neurons
from narx.kinematics.segment_angles import SAGITTAL
from narx.network.model import Narx
from narx.network.normalisation import Kind, Normalisation
from narx.network.stability import stability_statement
from narx.network.structure import NarxStructure
from narx.training.batch import InitialState, batch
from narx.training.objective import Log, Objective, Optimizer
from narx.windows.sequences import TrainingSequence


@dataclass(frozen=True)
class NetworkDesign:
    """What kind of network is to be trained.

    Parameters
    ----------
    hidden : int or {"auto"}
        Tanh neurons; ``auto`` takes as many as the sagittal gyroscope has major components
        (`narx.gait.spectrum.hidden_neurons`).
    input_lags, output_lags : int
        Delays.
    odd, coupled : bool
        As `narx.network.model.Narx`.
    normalisation : {"min_max", "max_abs", "std"}
        As `narx.network.normalisation.Normalisation.fit`.
    initial_state : {"teacher", "zero"}
        Of training sequences (`narx.windows.sequences.batch`).
    """

    hidden: int | Literal["auto"] = 3
    input_lags: int = 2
    output_lags: int = 2
    odd: bool = True
    coupled: bool = True
    normalisation: Kind = "std"
    initial_state: InitialState = "teacher"

    def untrained(self, training: Sequence[TrainingSequence], offset_free: bool) -> Narx:
        """Make a network with the scales of its training data.

        Parameters
        ----------
        training : sequence of TrainingSequence
            Of one sampling rate.
        offset_free : bool
            Take each sequence's mean angle off before the angle's scale is chosen.

        Returns
        -------
        Narx
            With zero weights.

        Raises
        ------
        UserError
            If the number of neurons or delays is not a positive number, or the normalisation is
            unknown, has offsets where there must be none, or has nothing that varies.
        """
        rates = np.concatenate([s.signals.axis_rates_rad_s[:, SAGITTAL] for s in training])
        targets = [s.target_rad[:, SAGITTAL] for s in training]
        if offset_free:
            targets = [target - np.nanmean(target) for target in targets]
        rate_hz = training[0].signals.sampling_rate_hz
        hidden = hidden_neurons(rates, rate_hz) if self.hidden == "auto" else self.hidden
        for name, value in (
            ("hidden", hidden),
            ("input_lags", self.input_lags),
            ("output_lags", self.output_lags),
        ):
            if not isinstance(value, int) or value < 1:
                raise UserError(f"model.{name} is '{value}', expected a positive whole number")
        if self.normalisation == "min_max" and (self.odd or self.coupled):
            raise UserError(
                "model.normalisation is 'min_max', which has offsets; expected std or max_abs, or "
                "model.odd=false and model.coupled=false"
            )
        try:
            scaled = Normalisation.fit(rates, np.concatenate(targets), self.normalisation)
        except ValueError as error:
            raise UserError(f"model.normalisation: {error}") from error
        return Narx(
            rate_hz,
            scaled,
            NarxStructure(int(hidden), 1, self.input_lags, self.output_lags),
            self.odd,
            self.coupled,
        )


def train_network(
    training: Sequence[TrainingSequence],
    validation: Sequence[TrainingSequence],
    design: NetworkDesign,
    objective: Objective,
    optimizer: Optimizer,
    rng: np.random.Generator,
    log: Log = lambda iteration, numbers: None,
) -> tuple[Narx, dict[str, Any]]:
    """Train a network.

    Parameters
    ----------
    training, validation : sequence of TrainingSequence
        The second chooses among starts.
    design : NetworkDesign
        Kind of network.
    objective : Objective
        What is minimised.
    optimizer : Optimizer
        Who minimises it.
    rng : numpy.random.Generator
        Draws the starts.
    log : callable
        Told how it goes.

    Returns
    -------
    model : Narx
        Trained network.
    history : dict
        Plain numbers and strings for a checkpoint: what it was trained on, the optimizer's
        report and a statement about its stability.
    """
    model = design.untrained(training, objective.offset_free)
    report = optimizer.fit(
        model,
        objective.with_rest(model, batch(training, model, design.initial_state)),
        batch(validation, model, design.initial_state),
        objective,
        rng,
        log,
    )
    history = {
        "trained_on": sorted({sequence.name for sequence in training}),
        "training_s": sum(sequence.duration_s for sequence in training),
        "report": asdict(report),
        "stability": asdict(stability_statement(model)),
    }
    return model, history
