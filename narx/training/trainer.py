"""Train a network on trials, on a fold, or on arrays, from a notebook or a command."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from narx.datasets.base import TrialSource
from narx.datasets.splits import Fold, TrialPart, load_calibrated
from narx.errors import UserError
from narx.inference.checkpoint import Checkpoint
from narx.inference.narx_method import AxisScaling
from narx.inference.start_up import StartUp
from narx.inference.tracker import PostureTracker
from narx.inference.washout import WASHOUT_S
from narx.kinematics.rate_unit import warn_of_degrees
from narx.recordings.trial import Trial
from narx.settings import PositiveSeconds, Seed, check_fields
from narx.training.design import NetworkDesign, train_network
from narx.training.levenberg_marquardt import LevenbergMarquardt
from narx.training.objective import Log, Objective, Optimizer
from narx.training.trial_reader import Stretch, TrialReader
from narx.windows.sequences import TrainingSequence, hold_back
from narx.windows.target_clock import on_gyroscope_clock


def _silent(iteration: int, numbers: dict[str, float]) -> None:
    """Log nothing."""


@dataclass(frozen=True)
class Trainer:
    """All settings of a training; `fit` runs it.

    Parameters
    ----------
    design : NetworkDesign
        Design of the network.
    objective : Objective
        Objective to minimise.
    optimizer : Optimizer
        Finds the weights.
    reader : TrialReader
        Cuts sequences from trials and provides the target angles; not used for given sequences.
    start_up : StartUp
        How the trained network starts.
    axis_scaling : {"training", "own"}
        As `narx.inference.NarxMethod`.
    washout_s : float, optional
        As `narx.inference.NarxMethod`, s; None for no washout.
    held_back : float
        Fraction of each training sequence, in [0, 0.9], held out at its end to choose among
        restarts if no validation data are given; with 0, the training data are used to choose.
    align_clock : bool
        Remove the lag of each trial's targets behind the gyroscope first, which the network would
        learn (`narx.windows.target_clock`).
    seed : int or numpy.random.Generator
        Seed of the starts.
    tracker : PostureTracker, optional
        Estimates posture and gyroscope bias while the network runs; replaces start-up and washout.
    start : Checkpoint, optional
        Trained network of the same design and sampling rate from which to continue: its scales are
        kept, and only the last stage of the curriculum is run.
    progress_folder : pathlib.Path, optional
        Folder for the state of an unfinished training. If an interrupted training is started again
        with the same settings, it continues from this state and ends with the same weights.

    Raises
    ------
    UserError
        If a value is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> from narx import Trainer
    >>> from narx.windows import from_arrays
    >>> time_s = np.arange(0, 20, 0.01)
    >>> angles = 0.4 * np.sin(2 * np.pi * time_s)[:, None] * [1.0, 0.2, 0.0]
    >>> rates = np.gradient(angles, 0.01, axis=0)
    >>> checkpoint = Trainer(seed=1).fit(from_arrays(rates, angles, 100.0))
    >>> bool(checkpoint.history["report"]["restarts"]["validation_rmse_best_deg"] < 1.0)
    True
    """

    design: NetworkDesign = field(default_factory=NetworkDesign)
    objective: Objective = field(default_factory=Objective)
    optimizer: Optimizer = field(default_factory=LevenbergMarquardt)
    reader: TrialReader = field(default_factory=TrialReader)
    start_up: StartUp = field(default_factory=StartUp)
    axis_scaling: AxisScaling = "training"
    washout_s: PositiveSeconds | None = WASHOUT_S
    held_back: Annotated[float, Field(ge=0, le=0.9)] = 0.25
    align_clock: bool = False
    seed: Seed | np.random.Generator = 0
    tracker: PostureTracker | None = None
    start: Checkpoint | None = None
    progress_folder: Path | None = None

    def __post_init__(self) -> None:
        check_fields(self, "training")
        if isinstance(self.optimizer, type):  # it has the methods, too
            name = self.optimizer.__name__
            raise UserError(f"training.optimizer is the class {name}, expected an object: {name}()")
        self.objective.for_axes(self.design.coupled)  # refuses what does not fit

    def fit(
        self,
        training: Iterable[Trial | TrainingSequence],
        validation: Iterable[Trial | TrainingSequence] = (),
        log: Log = _silent,
    ) -> Checkpoint:
        """Train on whole trials, on sequences, or on both.

        Parameters
        ----------
        training : iterable of Trial or TrainingSequence
            Training data; `narx.windows.from_arrays` makes sequences from arrays.
        validation : iterable of Trial or TrainingSequence, optional
            Data to choose among restarts; by default the end of every training sequence.
        log : callable, optional
            Progress callback, called with the iteration and numbers by name.

        Returns
        -------
        Checkpoint
            Trained network with its report and stability statement, and with its error if trials
            have a reference.

        Raises
        ------
        UserError
            If there is nothing to train on, or a target is not on the gyroscope's clock.
        """
        training = list(training)
        trials = [item for item in training if isinstance(item, Trial)]
        network = self._fit(self._sequences(training), self._sequences(validation), log)
        hashes = {name: sha for trial in trials for name, sha in trial.sources.items()}
        return self._measured(network, map(Stretch, trials), data_sha256=hashes)

    def fit_fold(
        self, sources: Mapping[str, TrialSource], fold: Fold, log: Log = _silent
    ) -> Checkpoint:
        """Train on the training part of a fold; its trials are in memory one at a time.

        Parameters
        ----------
        sources : mapping of str to TrialSource
            By name.
        fold : Fold
            Training and validation parts; the test part is not used.
        log : callable, optional
            As `fit`.

        Returns
        -------
        Checkpoint
            As `fit`.

        Raises
        ------
        UserError
            If there is nothing to train on.
        """
        hashes: dict[str, str] = {}

        def stretches(parts: Iterable[TrialPart]) -> Iterable[Stretch]:
            for part in parts:
                trial, segments = load_calibrated(sources, part, self.reader.calibration)
                hashes.update(trial.sources)
                yield Stretch(trial, part.start_s, part.stop_s, segments)

        training = self.reader.sequences(stretches(fold.training))
        validation = self.reader.sequences(stretches(fold.validation))
        network = self._fit(training, validation, log)
        trials = stretches({part.key: part for part in fold.training}.values())
        return self._measured(network, trials, fold=fold.name, data_sha256=hashes)

    def _sequences(self, data: Iterable[Trial | TrainingSequence]) -> list[TrainingSequence]:
        found: list[TrainingSequence] = []
        for item in data:
            if not isinstance(item, Trial | TrainingSequence):
                raise UserError(
                    f"training: found a {type(item).__name__}, expected trials or sequences"
                )
            found += self.reader.sequences([Stretch(item)]) if isinstance(item, Trial) else [item]
        return found

    def _fit(
        self, training: list[TrainingSequence], validation: list[TrainingSequence], log: Log
    ) -> Checkpoint:
        if not training:
            raise UserError("training: there is no sequence to train on")
        for sequence in training:
            warn_of_degrees(sequence.signals.axis_rates_rad_s, f"training: {sequence.name}")
        if self.align_clock:
            training, validation = map(on_gyroscope_clock, (training, validation))
        if not validation:
            training, validation = hold_back(training, self.held_back)
        model, history = train_network(
            training,
            validation,
            self.design,
            self.objective,
            self.optimizer,
            np.random.default_rng(self.seed),
            log,
            None if self.start is None else self.start.model,
            self.progress_folder,
        )
        return Checkpoint(
            model,
            self.start_up,
            self.axis_scaling,
            history=history,
            washout_s=self.washout_s,
            tracker=self.tracker,
        )

    def _measured(
        self, network: Checkpoint, trials: Iterable[Stretch], **history: Any
    ) -> Checkpoint:
        if network.tracker is not None:
            scale = self.reader.std_scale(network.method(), trials)
            return replace(
                network,
                tracker=replace(network.tracker, std_scale=scale),
                history=network.history | history,
            )
        after, start = self.reader.error_stds(network.method(), trials)
        return replace(
            network,
            error_std_rad=after,
            start_std_rad=start,
            history=network.history | history,
        )
