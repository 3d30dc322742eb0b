"""Schemas of all commands; those of sections with a `_target_` follow from their classes."""

from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, Field

from narx.calibration.calibrate import Mode
from narx.datasets.base import TrialSource
from narx.experiments.configuration.components import Component, Components
from narx.experiments.model import ModelSettings
from narx.experiments.reports.report import Report
from narx.inference.narx_method import AxisScaling
from narx.inference.predict import Frame, Side
from narx.inference.session import SessionStart
from narx.method import OrientationMethod
from narx.recordings.session_clock import Alignment
from narx.settings.checked import CONFIG
from narx.settings.values import (
    FilePath,
    Fraction,
    Interval,
    Name,
    Names,
    Positive,
    PositiveSeconds,
    SamplingRate,
    Seconds,
    Seed,
)
from narx.simulation.session import ErrorSource
from narx.training.objective import Optimizer
from narx.training.teachers import Teacher

Format = Literal["torchscript", "torch_export", "onnx", "c"]


class Section(BaseModel):
    """Part of a configuration; keys that are not listed are refused."""

    model_config = CONFIG


class Selection(Section):
    """Trials to select, by names or lists of names."""

    subject: Names | None = None
    condition: Names | None = None
    trial: Names | None = None


class Training(Section):
    """The parts of the trials used for training."""

    seed: Seed = 0
    skip_s: Seconds = 5.0
    held_back: Fraction = 0.25
    align_clock: bool = False
    start: FilePath | None = None
    segments: Names | None = None
    weights: dict[Name, Positive] = {}


class Walks(Section):
    """Settings of `data.simulated_gait` that a preset overrides (checked there)."""

    subjects: Any = None
    protocol: Any = None
    conditions: Any = None
    trials_per_condition: Any = None
    treadmill_duration_s: Any = None
    steps: Any = None
    sampling_rate_hz: Any = None
    sensor: Any = None
    mounting: Any = None
    segments: Any = None


class Prepared(Section):
    """Storage of prepared trials."""

    folder: FilePath | None = None
    limit_gb: Annotated[float, Field(ge=0, le=1e6)] = 4.0


class Common(Section):
    """As ``configs/common.yaml``."""

    seed: Seed = 0
    data_root: FilePath | None = None
    select: Selection = Selection()
    calibration: Mode = "auto"
    candidates: tuple[Name, ...] = ()
    resume: Literal["auto", "never"] = "auto"
    training: Training = Training()
    prepared: Prepared = Prepared()
    walks: Walks | None = None
    profile: bool = False
    data: Annotated[Any, Components(TrialSource, (("seed", Seed),))]
    model: Annotated[Any, Component(ModelSettings)]
    optimizer: Annotated[Any, Component(Optimizer)]
    teacher: Annotated[Any, Component(Teacher)]
    split: Annotated[Any, Component(None, ("index",))]


Target = Annotated[
    str,
    Field(
        pattern="^(held_back_error_deg|n_weights|rmse_deg/.+/.+/narx)$",
        description="held_back_error_deg, n_weights or rmse_deg/<segment>/<axis>/narx",
    ),
]


Ignored = Annotated[Any, Field(exclude=True)]


class Train(Common):
    """As ``configs/train.yaml``."""

    objectives: Annotated[
        tuple[Target, ...], Field(min_length=1, description="a list of at least one")
    ] = ("held_back_error_deg",)
    # an experiment's settings of its benchmark have no effect on training
    report: Ignored = None
    methods: Ignored = None
    method: Ignored = None
    evaluation: Ignored = None
    remove_static_bias: Ignored = None
    forms: Ignored = None
    choose: Ignored = None
    as_printed: Annotated[
        None, Field(exclude=True, description="experiment=tham_as_printed with narx-benchmark only")
    ] = None


class Evaluation(Section):
    """The scored part of a trial, and the rate of the figures."""

    skip_s: Seconds = 5.0
    scored_rate_hz: Annotated[float, Field(ge=1, le=10_000)] | None = 100.0
    confidence: Annotated[float, Field(gt=0, lt=1)] = 0.95
    figure_rate_hz: Annotated[float, Field(ge=1, le=10_000)] = 50.0


class PrintedVariant(Section):
    """What differs from training as printed."""

    curriculum: Annotated[tuple[Literal["open", "closed"], ...], Field(min_length=1)] = ("open",)
    prior_deg2: Annotated[float, Field(ge=0)] = 0.0
    axis_scaling: AxisScaling = "training"
    starts: Literal["normal", "leaky_integrator"] = "normal"
    restarts: Annotated[int, Field(ge=1, le=1000)] = 1
    target: Literal["filter", "reference"] = "filter"


class AsPrinted(Section):
    """As ``configs/as_printed.yaml``."""

    seed: Seed = 0
    draws: Annotated[int, Field(ge=1, le=10_000)] = 20
    subjects: Names = ("S1", "S2", "S3", "S4", "S5")
    condition: Literal["slow", "normal", "fast"] = "normal"
    duration_s: PositiveSeconds = 60.0
    sampling_rate_hz: SamplingRate = 500.0
    calibration: Mode = "functional"
    window_s: PositiveSeconds = 10.0
    skip_s: Seconds = 5.0
    crossover_hz: Positive = 0.1
    power_fraction: Annotated[float, Field(gt=0, lt=1)] = 0.98
    iterations: Annotated[int, Field(ge=1, le=100_000)] = 300
    variants: Annotated[dict[Name, PrintedVariant], Field(min_length=1)]


class Benchmark(Common):
    """As ``configs/benchmark.yaml``."""

    methods: Names = (
        "narx", "narx_axis_by_axis", "leaky_integrator", "pseudo_integrator",
        "complementary_filter", "gyro_integration", "strapdown", "vqf", "madgwick", "mahony",
        "constant", "zero",
    )  # fmt: skip
    checkpoint: FilePath | None = None
    remove_static_bias: bool = True
    evaluation: Evaluation = Evaluation()
    method: Annotated[Any, Components(OrientationMethod)]
    model_axis_by_axis: Annotated[Any, Component(ModelSettings)]
    forms: dict[Name, dict[Name, Any] | None] = {}
    choose: bool = True
    grid: dict[Name, dict[Name, Annotated[tuple[Any, ...], Field(min_length=1)]]] = {}
    report: Annotated[Any, Component(Report)]
    as_printed: AsPrinted | None = None


class Export(Section):
    """As ``configs/export.yaml``."""

    checkpoint: FilePath | None = None
    format: Format = "torchscript"
    output: FilePath
    precision: Literal["double", "float"] | None = None
    verify: bool = True


Columns = Annotated[
    dict[Name, Any], Field(description="a section with time, gyroscope and accelerometer")
]


class Predict(Section):
    """As ``configs/predict.yaml``."""

    input: FilePath | dict[Name, FilePath] | None = None
    data: Annotated[Any, Components(TrialSource, optional=True)] = {}
    data_root: FilePath | None = None
    select: Selection = Selection()
    output: FilePath
    columns: Columns | None = None
    device: FilePath | None = None
    checkpoint: FilePath | None = None
    frame: Frame = "auto"
    side: Side = "right"
    start_pose: SessionStart = "auto"
    remove_bias: bool = True
    still_s: Interval | tuple[Interval, ...] | None = None
    still_file: FilePath | None = None
    bias_rad_s: tuple[float, float, float] | None = None
    calibration: Mode = "auto"
    align: Alignment | dict[Name, float] = "auto"
    walking_s: Interval | None = None
    format: Literal["csv", "parquet", "sto", "mot", "c3d", "motion_bids"] = "csv"
    partition_s: Annotated[float, Field(ge=120, le=86_400)] = 900.0
    jobs: Annotated[int, Field(ge=1, le=1024)] | None = None
    scheduler: Name | None = None
    smoothing: bool = False


class DraftStudy(Section):
    """As ``configs/draft_study.yaml``."""

    input: FilePath
    overwrite: bool = False


class DemoRecordings(Section):
    """As ``configs/demo_recordings.yaml``."""

    output: FilePath = "demo"
    duration_s: Annotated[float, Field(ge=20, le=3600)] = 60


class Endurance(Section):
    """As ``configs/endurance.yaml``."""

    output: FilePath = "endurance"
    hours: Annotated[float, Field(ge=0, le=1000)] = 24
    dask_minutes: Annotated[float, Field(ge=0, le=1440)] = 20
    files: Annotated[int, Field(ge=0, le=100_000)] = 2000
    jobs: Annotated[int, Field(ge=1, le=1024)] = 1


class Ablation(Section):
    """As ``configs/ablation.yaml``."""

    seed: Seed = 0
    data_root: FilePath | None = None
    overrides: tuple[Name, ...] = (
        "data=smartphone_pocket",
        "select.condition=[NoDist_FrontPocket]",
        "split=leave_one_subject_out",
        "model.tracker=null",
    )
    variants: dict[Name, tuple[Name, ...]]


class Optimizers(Section):
    """As ``configs/optimizers.yaml``."""

    seed: Seed = 0
    data_root: FilePath | None = None
    optimizers: Names = ("levenberg_marquardt", "lbfgs", "adam")
    overrides: tuple[Name, ...] = ()
    data: Annotated[dict[Name, tuple[Name, ...]], Field(min_length=1)]


class Variant(Section):
    """One variant of simulated walks and of their calibration."""

    without: tuple[ErrorSource, ...] = ()
    calibration: Literal["exact", *get_args(Mode)] = "auto"  # type: ignore[valid-type]


class ErrorBudget(Section):
    """As ``configs/error_budget.yaml``."""

    seed: Seed = 0
    seeds: Annotated[tuple[Seed, ...], Field(min_length=1)] = (0,)
    subjects: Names = ("S1", "S2", "S3", "S4", "S5")
    duration_s: PositiveSeconds = 60.0
    sampling_rate_hz: SamplingRate = 100.0
    skip_s: Seconds = 5.0
    checkpoint: FilePath | None = None
    variants: dict[Name, Variant]


class PageSource(Section):
    """One benchmark of the page, and how it is presented."""

    title: Name
    overrides: tuple[Name, ...] = ()
    segment: Name
    quantity: Literal["rmse_deg", "precision_deg"]
    figures: dict[Name, Name] = {}


class Glance(Section):
    """The README's table, sentences and figures."""

    figures: Name | None = None

    sources: dict[Name, Name]
    methods: Names


class BenchmarkPage(Section):
    """As ``configs/benchmark_page.yaml``."""

    root: FilePath = "."
    data_root: FilePath | None = None
    measure: bool = True
    only: Names | None = None
    sources: dict[Name, PageSource]
    as_printed: tuple[Name, ...] = ()
    glance: Glance


class Speed(Section):
    """As ``configs/speed.yaml``."""

    seed: Seed = 0
    n_samples: Annotated[int, Field(ge=100, le=1_000_000)] = 5000
    n_rollout_samples: Annotated[int, Field(ge=100, le=10_000_000)] = 150_000
    n_channels: Annotated[int, Field(ge=1, le=10_000)] = 180
    n_starts: Annotated[int, Field(ge=1, le=10_000)] = 64
    n_cost_starts: Annotated[int, Field(ge=1, le=10_000)] = 16
    iterations: Annotated[int, Field(ge=1, le=10_000)] = 100
    repeats: Annotated[int, Field(ge=1, le=10_000)] = 15
    slow_repeats: Annotated[int, Field(ge=1, le=10_000)] = 3
    slow_samples: Annotated[int, Field(ge=100, le=10_000_000)] = 15_000
    first_use: bool = True
    peers: bool = True


SCHEMAS: dict[str, type[Section]] = {
    "train": Train,
    "benchmark": Benchmark,
    "benchmark_page": BenchmarkPage,
    "as_printed": AsPrinted,
    "export": Export,
    "predict": Predict,
    "demo_recordings": DemoRecordings,
    "draft_study": DraftStudy,
    "endurance": Endurance,
    "ablation": Ablation,
    "optimizers": Optimizers,
    "error_budget": ErrorBudget,
    "speed": Speed,
}
