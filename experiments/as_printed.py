"""Train the network as printed by Tham et al. (2020) over many draws, and variants of it.

python -m experiments.as_printed

As printed (section II-B2): 10 s of one segment of one subject at normal speed, both drawn at
random; sagittal gyroscope and sagittal angle of the complementary filter; as many neurons as the
gyroscope has components with 98 % of its power; inputs and angles mapped onto -1..1, biases,
independent axes; random starts, zero initial states; Levenberg-Marquardt one step ahead
(series-parallel), then the loop is closed. Not specified in the paper, and chosen here: normally
distributed starts with a standard deviation of 0.5, and the scale of the untrained axes.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from omegaconf import DictConfig
from tqdm import tqdm

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.calibration.calibrate import CalibratedSegment, calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.datasets.splits import TrialPart
from narx.errors import UserError
from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.evaluation.trial import evaluate_trial
from narx.experiments.command import command, run_directory
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.tables.as_printed import as_printed_table
from narx.files import atomic_path
from narx.gait.spectrum import hidden_neurons
from narx.inference.narx_method import AxisScaling, NarxMethod
from narx.inference.start_up import StartUp
from narx.kinematics.segment_angles import SAGITTAL
from narx.recordings.trial import Trial, kind_of
from narx.training.batch import batch
from narx.training.design import NetworkDesign
from narx.training.initial_weights import random_weights
from narx.training.least_squares.problem import LeastSquaresProblem
from narx.training.least_squares.solver import Options
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import multi_start
from narx.training.objective import Objective
from narx.training.stages import closed_loop_fit, stages_of
from narx.types import FloatArray
from narx.windows.sequences import TrainingSequence

# sagittal axis only, mean errors included, no return to rest
_OBJECTIVE = Objective((1.0, 0.0, 0.0), offset_free=False, rest_weight=0.0)
_SCORED_RATE_HZ = 100.0
# of a benchmark's configuration, that matter for this experiment
_KEYS = frozenset({"experiment", "as_printed", "seed", "profile"})
# of the weights of a plain random start
_START_SD = 0.5


@dataclass(frozen=True)
class Trained:
    """A network trained on one draw.

    Parameters
    ----------
    method : NarxMethod
        The network, started from zero.
    one_step_deg : float
        RMSE on its window one step ahead, deg.
    closed_loop_deg : float
        RMSE on its window in closed loop from a state of zero, deg.
    """

    method: NarxMethod
    one_step_deg: float
    closed_loop_deg: float


def draw_window(
    walks: Sequence[tuple[Trial, Mapping[str, CalibratedSegment]]],
    window_s: float,
    skip_s: float,
    rng: np.random.Generator,
) -> tuple[Trial, CalibratedSegment, slice]:
    """Draw a walk, a segment of it and a window.

    Parameters
    ----------
    walks : sequence of tuple of Trial and mapping of str to CalibratedSegment
        Walks to draw from, each with its segments.
    window_s : float
        Length of the window, s.
    skip_s : float
        Length of the start of a walk that is excluded from the draw, s.
    rng : numpy.random.Generator
        Random number generator.

    Returns
    -------
    trial : Trial
        The walk.
    segment : CalibratedSegment
        One of its thighs and shanks.
    window : slice
        Samples of the window.

    Raises
    ------
    UserError
        If the walk is too short.
    """
    trial, calibrated = walks[int(rng.integers(len(walks)))]
    names = [name for name in calibrated if kind_of(name) in ("thigh", "shank")]
    segment = calibrated[names[int(rng.integers(len(names)))]]
    rate_hz = trial.sampling_rate_hz
    n, first = round(window_s * rate_hz), round(skip_s * rate_hz)
    if first + n > trial.n_samples:
        raise UserError(
            f"window_s: {trial.name} lasts {trial.n_samples / rate_hz:g} s, expected at least "
            f"{skip_s + window_s:g} s"
        )
    begin = int(rng.integers(first, trial.n_samples - n + 1))
    return trial, segment, slice(begin, begin + n)


def sequence_of(
    segment: CalibratedSegment, window: slice, target_rad: FloatArray
) -> TrainingSequence:
    """Cut a window out of a segment.

    Parameters
    ----------
    segment : CalibratedSegment
        Its signals.
    window : slice
        Samples.
    target_rad : ndarray, shape (N, 3)
        Target angles of the whole recording.

    Returns
    -------
    TrainingSequence
        Sequence of the window.
    """
    signals = segment.signals.select(window)
    return TrainingSequence(segment.signals.segment, signals, target_rad[window])


def train_as_printed(
    sequence: TrainingSequence,
    variant: DictConfig,
    neurons: int,
    iterations: int,
    rng: np.random.Generator,
) -> Trained:
    """Train one network.

    Parameters
    ----------
    sequence : TrainingSequence
        Window with its target.
    variant : omegaconf.DictConfig
        Differences from the paper, as in ``configs/as_printed.yaml``.
    neurons : int
        Hidden neurons.
    iterations : int
        Maximum number of evaluations per stage.
    rng : numpy.random.Generator
        Draws the starts.

    Returns
    -------
    Trained
        The network and its errors.
    """
    design = NetworkDesign(
        neurons, odd=False, coupled=False, normalisation="min_max", initial_state="zero"
    )
    model = design.untrained([sequence], offset_free=False)
    window = batch([sequence], model, "zero")
    stages = stages_of(model, window, _OBJECTIVE, variant.curriculum, variant.prior_deg2)
    if variant.starts == "leaky_integrator":
        starts = np.array([random_weights(model, rng) for _ in range(variant.restarts)])
    else:
        starts = _START_SD * rng.standard_normal((variant.restarts, model.structure.n_weights))
    closed, unit_deg2 = closed_loop_fit(model, window, _OBJECTIVE, "training")
    options = Options(Stopping(max_evaluations=iterations))
    found = multi_start(stages, starts, closed, options, trainable=model.trainable.numpy())
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(found.weights))
    (ahead,) = stages_of(model, window, _OBJECTIVE, ["open"], 0.0)
    scaling: AxisScaling = variant.axis_scaling
    return Trained(
        NarxMethod(model, StartUp(duration_s=0.0), scaling, washout_s=None),
        _root_mean_square(ahead.problem, found.weights, ahead.mean_square),
        _root_mean_square(closed, found.weights, unit_deg2 / closed.total_weight),
    )


def _root_mean_square(
    problem: LeastSquaresProblem, weights: FloatArray, mean_square: float
) -> float:
    return float(np.sqrt(problem.products(weights[None])[0, -1, -1] * mean_square))


def scores(
    walks: Sequence[tuple[Trial, Mapping[str, CalibratedSegment]]],
    methods: Mapping[str, NarxMethod],
    skip_s: float,
) -> pd.DataFrame:
    """Compare networks with the reference on all walks.

    Parameters
    ----------
    walks : sequence of tuple of Trial and mapping of str to CalibratedSegment
        Test walks, each with its segments.
    methods : mapping of str to NarxMethod
        By name.
    skip_s : float
        Start of each walk that is not scored, s.

    Returns
    -------
    pandas.DataFrame
        RMSE in degrees, mean over walks and sides: one row per method, columns such as
        ``knee_sagittal_deg`` for knee, thigh and shank and each of
        `narx.kinematics.segment_angles.AXES`.
    """
    found = []
    for trial, calibrated in walks:
        part = TrialPart(trial.dataset, trial.subject, trial.condition, trial.trial)
        evaluated, _ = evaluate_trial(
            trial, calibrated, methods, part, skip_s, scored_rate_hz=_SCORED_RATE_HZ
        )
        found += [row for one in evaluated for row in rows(one)]
    results = results_table(found)
    kinds = results["segment"].map(kind_of)
    means = results.groupby(["method", kinds, "axis"])["rmse_deg"].mean().unstack([1, 2])
    means.columns = ["_".join([*names, "deg"]) for names in means.columns]
    return means


def run(cfg: DictConfig) -> pd.DataFrame:
    """Train all draws of all variants and score them.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/as_printed.yaml``.

    Returns
    -------
    pandas.DataFrame
        A row per draw and variant: ``variant``, ``draw``, ``trained_on``, ``neurons``,
        ``one_step_deg``, ``closed_loop_deg``, and the columns of `scores`.

    Raises
    ------
    UserError
        If the walks are shorter than the window.
    """
    source = SimulatedGait(
        subjects=tuple(cfg.subjects),
        conditions=(cfg.condition,),
        treadmill_duration_s=cfg.duration_s,
        sampling_rate_hz=cfg.sampling_rate_hz,
        seed=cfg.seed,
    )
    walks = [(trial, calibrate(trial, cfg.calibration)) for trial in source]
    teacher = ComplementaryFilter(crossover_hz=cfg.crossover_hz)
    methods: dict[str, NarxMethod] = {}
    about: list[dict[str, object]] = []
    for draw in tqdm(range(cfg.draws), desc="draws", disable=None):
        trial, segment, window = draw_window(
            walks, cfg.window_s, cfg.skip_s, np.random.default_rng([cfg.seed, draw])
        )
        rates = segment.signals.axis_rates_rad_s[window, SAGITTAL]
        neurons = hidden_neurons(rates, trial.sampling_rate_hz, cfg.power_fraction)
        assert segment.reference_angles_rad is not None  # walks are simulated
        targets = {
            "filter": teacher.estimate(segment.signals),
            "reference": segment.reference_angles_rad,
        }
        for name, variant in cfg.variants.items():
            sequence = sequence_of(segment, window, targets[variant.target])
            rng = np.random.default_rng([cfg.seed, draw, 1])
            trained = train_as_printed(sequence, variant, neurons, cfg.iterations, rng)
            methods[f"{name}/{draw}"] = trained.method
            about.append(
                {
                    "method": f"{name}/{draw}",
                    "variant": name,
                    "draw": draw,
                    "trained_on": f"{trial.subject}/{segment.signals.segment}",
                    "neurons": neurons,
                    "one_step_deg": trained.one_step_deg,
                    "closed_loop_deg": trained.closed_loop_deg,
                }
            )
    results = pd.DataFrame(about).join(scores(walks, methods, cfg.skip_s), on="method")
    return results.drop(columns="method")


def check_overrides(overrides: Iterable[str]) -> None:
    """Refuse keys of the comparison of methods beside ``experiment=tham_as_printed``.

    Parameters
    ----------
    overrides : iterable of str
        Overrides of the benchmark, as given on the command line.

    Raises
    ------
    UserError
        If one would have no effect.
    """
    for override in overrides:
        key = override.lstrip("+~").partition("=")[0]
        if key.partition(".")[0] not in _KEYS:
            raise UserError(
                f"{key}: has no effect with experiment=tham_as_printed, expected as_printed.* or "
                f"one of {', '.join(sorted(_KEYS - {'as_printed'}))}"
            )


def write_draws(results: pd.DataFrame, path: Path) -> None:
    """Write what `run` has returned.

    Parameters
    ----------
    results : pandas.DataFrame
        Its rows.
    path : pathlib.Path
        CSV file.
    """
    with atomic_path(path) as temporary:
        results.to_csv(temporary, index=False, float_format="%.6g", lineterminator="\n")


def report(cfg: DictConfig) -> None:
    """Train and score, and write table and draws to the run directory.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/as_printed.yaml``.
    """
    seed_everything(cfg.seed)
    directory = run_directory()
    results = run(cfg)
    write_draws(results, directory / "as_printed.csv")
    write_json(environment(cfg.seed, {}), directory / "environment.json")
    text = as_printed_table(results).to_markdown()
    with atomic_path(directory / "as_printed.md") as temporary:
        temporary.write_text(text)
    print(text)
    print(f"as_printed.csv and as_printed.md: {directory}")


main = command("as_printed")(report)

if __name__ == "__main__":
    main()
