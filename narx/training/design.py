"""Training of a network from training sequences."""

import copy
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from narx.errors import UserError
from narx.gait.spectrum import hidden_neurons
from narx.kinematics.segment_angles import SAGITTAL
from narx.network.model import Narx
from narx.network.normalisation import Kind, Normalisation
from narx.network.stability import stability_statement
from narx.network.structure import NarxStructure
from narx.settings import check_fields
from narx.training.batch import InitialState, batch
from narx.training.objective import Log, Objective, Optimizer
from narx.training.progress import Progress, fingerprint
from narx.windows.sequences import TrainingSequence

# compiled loops are unrolled over neurons and delays, and the normal equations of every start grow
# with the square of the number of weights
_MOST_WEIGHTS = 600
_Size = Annotated[int, Field(ge=1, le=64)]


@dataclass(frozen=True)
class NetworkDesign:
    """Design of a network to be trained.

    Parameters
    ----------
    hidden : int or {"auto"}
        Tanh neurons; ``auto`` uses as many as the sagittal gyroscope has major components
        (`narx.gait.spectrum.hidden_neurons`).
    input_lags, output_lags : int
        Delays.
    odd, coupled : bool
        As `narx.network.model.Narx`.
    normalisation : {"min_max", "max_abs", "std"}
        As `narx.network.normalisation.Normalisation.fit`.
    initial_state : {"teacher", "zero"}
        Of training sequences (`narx.training.batch.batch`).

    Raises
    ------
    UserError
        If a value is out of its range, the normalisation has offsets where there must be none,
        or the network would have more weights than a training can hold in memory.
    """

    hidden: _Size | Literal["auto"] = 3
    input_lags: _Size = 2
    output_lags: _Size = 2
    odd: bool = True
    coupled: bool = True
    normalisation: Kind = "std"
    initial_state: InitialState = "teacher"

    def __post_init__(self) -> None:
        check_fields(self, "model")
        hidden = 1 if self.hidden == "auto" else self.hidden
        self._check_size(hidden)
        if self.normalisation == "min_max" and (self.odd or self.coupled):
            raise UserError(
                "model.normalisation is 'min_max', which has offsets; expected std or max_abs, or "
                "model.odd=false and model.coupled=false"
            )

    def _check_size(self, hidden: int) -> None:
        structure = NarxStructure(hidden, 1, self.input_lags, self.output_lags)
        if structure.n_weights > _MOST_WEIGHTS:
            raise UserError(
                f"model: {hidden} hidden neurons with {self.input_lags} input and "
                f"{self.output_lags} output lags have {structure.n_weights} weights, at most "
                f"{_MOST_WEIGHTS} can be trained"
            )

    def untrained(self, training: Sequence[TrainingSequence], offset_free: bool) -> Narx:
        """Create a network with the scales of its training data.

        Parameters
        ----------
        training : sequence of TrainingSequence
            Sequences with the same sampling rate.
        offset_free : bool
            Subtract each sequence's mean angle before the angle's scale is chosen.

        Returns
        -------
        Narx
            Network with zero weights.

        Raises
        ------
        UserError
            If rates or angles do not vary, or ``auto`` gives too large a network.
        """
        rates = np.concatenate([s.signals.axis_rates_rad_s[:, SAGITTAL] for s in training])
        targets = [s.target_rad[:, SAGITTAL] for s in training]
        if offset_free:
            targets = [target - np.nanmean(target) for target in targets]
        rate_hz = training[0].signals.sampling_rate_hz
        hidden = hidden_neurons(rates, rate_hz) if self.hidden == "auto" else self.hidden
        self._check_size(hidden)
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

    def check_same(self, network: Narx) -> None:
        """Refuse a network of a different design.

        Parameters
        ----------
        network : Narx
            Previously trained network.

        Raises
        ------
        UserError
            If the design differs; the message names the difference.
        """
        structure = network.structure
        for name, has in (
            ("hidden", structure.hidden),
            ("input_lags", structure.input_lags),
            ("output_lags", structure.output_lags),
            ("odd", network.odd),
            ("coupled", network.coupled),
        ):
            wanted = getattr(self, name)
            if wanted not in (has, "auto"):
                raise UserError(
                    f"training.start is a network with {name}={has}, model.{name} is {wanted}"
                )


def train_network(
    training: Sequence[TrainingSequence],
    validation: Sequence[TrainingSequence],
    design: NetworkDesign,
    objective: Objective,
    optimizer: Optimizer,
    rng: np.random.Generator,
    log: Log = lambda iteration, numbers: None,
    start: Narx | None = None,
    progress_folder: Path | None = None,
) -> tuple[Narx, dict[str, Any]]:
    """Train a network.

    Parameters
    ----------
    training, validation : sequence of TrainingSequence
        The second is used to choose among starts.
    design : NetworkDesign
        Design of the network.
    objective : Objective
        Objective to minimise.
    optimizer : Optimizer
        Optimiser.
    rng : numpy.random.Generator
        Draws the starts.
    log : callable
        Called with iteration and numbers by name.
    start : Narx, optional
        Trained network of the same design from which to continue; its scales are kept.
    progress_folder : pathlib.Path, optional
        Where the state of the training is kept while it lasts, in a file named by what is trained:
        the same training goes on from there.

    Returns
    -------
    model : Narx
        Trained network.
    history : dict
        Plain numbers and strings for a checkpoint: training data, the optimizer's report and a
        statement about stability.

    Raises
    ------
    UserError
        If the network to continue from has a different design.
    """
    objective = objective.for_axes(design.coupled)
    if start is None:
        model = design.untrained(training, bool(objective.offset_free))
    else:
        design.check_same(start)
        model = copy.deepcopy(start)
    problem = objective.with_rest(model, batch(training, model, design.initial_state))
    held_back = batch(validation, model, design.initial_state)
    further: dict[str, Any] = {}
    if progress_folder is not None and "progress" in signature(optimizer.fit).parameters:
        name = fingerprint(
            (model.to_config(), objective, optimizer, rng.bit_generator.state),
            [model.weights, *vars(problem).values(), *vars(held_back).values()],
        )
        further["progress"] = Progress(progress_folder / f"{name[:16]}.pt")
    report = optimizer.fit(
        model,
        problem,
        held_back,
        objective,
        rng,
        log,
        None if start is None else start.weights.detach().numpy(),
        **further,
    )
    history = {
        "trained_on": sorted({sequence.name for sequence in training}),
        "training_s": sum(sequence.duration_s for sequence in training),
        "report": asdict(report),
        "stability": asdict(stability_statement(model)),
    }
    return model, history
