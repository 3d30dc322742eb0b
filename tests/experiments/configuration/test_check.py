"""Every key of every command is validated before data are read, with one-line errors."""

from importlib import resources

import pytest
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from narx.datasets.splits import Fold
from narx.errors import UserError
from narx.experiments.configuration.schemas import SCHEMAS
from narx.experiments.overrides import readable
from narx.experiments.train import only_fold

REQUIRED = {"export": ["output=a.pt"], "predict": ["output=b.csv"],
            "draft_study": ["input=a"]}  # fmt: skip


@pytest.mark.parametrize("command", SCHEMAS)
def test_the_documented_defaults_pass(compose_checked, command):
    assert compose_checked(command, *REQUIRED.get(command, []))


@pytest.mark.parametrize(
    "overrides",
    [
        ["experiment=tham_knee_angle"],
        ["experiment=abhayasinghe_thigh_angle"],
        ["experiment=han_two_point"],
        ["data=[smartphone_pocket,simulated_gait]", "split=leave_one_subject_out"],
        ["model=tham_literal", "optimizer=lbfgs", "teacher=reference"],
        ["optimizer=adam", "split=one_window", "training.segments=[thigh_right]"],
        ["split=within_trial", "data=neura_sample", "data.neura_sample.sampling_rate_hz=50"],
    ],
)
def test_the_documented_choices_pass(compose_checked, overrides):
    assert compose_checked("benchmark", *overrides)


@pytest.mark.parametrize(
    "experiment", ["tham_knee_angle", "abhayasinghe_thigh_angle", "han_two_point"]
)
def test_training_takes_the_walks_of_an_experiment(compose_checked, experiment):
    cfg = compose_checked("train", f"experiment={experiment}", "split=everything")
    assert not {"report", "methods", "forms", "choose"} & set(cfg)
    with pytest.raises(UserError, match="this split only tests"):
        only_fold([Fold("all", (), ())])


def test_training_refuses_the_experiment_that_trains_by_itself(compose_checked):
    with pytest.raises(UserError, match="expected experiment=tham_as_printed with narx-benchmark"):
        compose_checked("train", "experiment=tham_as_printed")


@pytest.mark.parametrize(("command", "debug"), [("train", "overfit"), ("benchmark", "tiny")])
def test_a_debug_preset_is_for_every_source(compose_checked, command, debug):
    with resources.as_file(resources.files("narx.configs") / "data") as folder:
        sources = sorted(path.stem for path in folder.glob("*.yaml"))
    for source in sources:
        cfg = compose_checked(command, f"debug={debug}", f"data={source}")
        assert set(cfg.data) == {source, "seed"}
    both = compose_checked(command, f"debug={debug}", "data=[broad,simulated_gait]")
    own = compose_checked(command, f"debug={debug}", "data.simulated_gait.subjects=[V7]")
    assert own.data.simulated_gait.subjects == ["V7"]
    assert both.data.simulated_gait.treadmill_duration_s == 60.0
    assert both.data.simulated_gait.subjects == ["S1"]
    assert (own.split.window_s, own.split.earliest_s) == (8.0 if debug == "tiny" else 3.0, 8.0)
    # a split of one's own replaces that of the preset
    other = compose_checked(command, f"debug={debug}", "split=leave_one_subject_out")
    assert other.split.column == "subject"


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("model.hidden=abc", "model.hidden is 'abc', expected a whole number"),
        ("model.hidden=1e400", "model.hidden is inf, expected a whole number"),
        ("model.initial_state=foo", "model.initial_state is 'foo', expected one of teacher, zero"),
        ("model.axis_scaling=foo", "model.axis_scaling is 'foo', expected one of training, own"),
        ("model.coupled=maybe", "model.coupled is 'maybe', expected true or false"),
        ("model.washout_s=0", "washout_s is 0"),
        ("model.start_up.averaging_s=-3", "model.start_up.averaging_s is -3, expected a number ab"),
        ("+training.weights.simulatd=2", "training.weights.simulatd: unknown source, data has sim"),
        ("candidates=[model.hidden=a]", "candidates.0 is 'model.hidden=a': model.hidden is 'a', e"),
        ("candidates=[model.foo=1]", "candidates.0 is 'model.foo=1': model.foo: unknown key"),
        ("candidates=[abc]", "candidates.0 is 'abc': expected"),
        ("model.start_up.averaging_s=null", "model.start_up.averaging_s is null, expected a num"),
        ("optimizer.prior_deg2=nan", "optimizer.prior_deg2 is nan, expected a number"),
        (
            "training.held_back=1.5",
            "training.held_back is 1.5, expected a number of at least 0 and",
        ),
        ("training.skip_s=-1", "training.skip_s is -1, expected a number from 0 to"),
        ("training.skip_s=1e300", "training.skip_s is 1e+300, expected a number from 0 to"),
        ("+training.batch_size=32", "training.batch_size: unknown key, the closest is tr"),
        ("+training.weights.simulated_gait=0", "training.weights.simulated_gait is 0, expected"),
        ("optimizer.restarts=0", "optimizer.restarts is 0, expected a whole number from 1 to"),
        ("resume=perhaps", "resume is 'perhaps', expected one of auto, never"),
        ("seed=abc", "seed is 'abc', expected a whole number"),
        ("seed=-1", "seed is -1, expected a whole number"),
        ("seed=true", "seed is true, expected a whole number"),
        ("seed=1.5", "seed is 1.5, expected a whole number"),
        ("seed=[1]", "seed is [1], expected a whole number"),
        ("seed={a:1}", "seed is {'a': 1}, expected a whole number"),
        ("seed=null", "seed is null, expected a whole number"),
        ("+model.foo=1", "model.foo: unknown key, the closest is model.odd"),
        ("+model.hiden=1", "model.hiden: unknown key, the closest is model.hidden"),
        ("+modle=1", "modle: unknown key, the closest is model"),
        ("+model._partial_=true", "model._partial_: unknown key"),
        ("~model", "model is null, expected a section"),
        ("~teacher.method", "teacher.method is missing"),
        ("model._target_=null", "model._target_ is null, expected the import path"),
        ("model._target_=os.system", "model._target_ is 'os.system', expected the import path of"),
        ("model._target_=no.such.thing", "model._target_ is 'no.such.thing', expected the import"),
        ("split._target_=os.system", "split._target_ is 'os.system', expected the import path of"),
        ("data.simulated_gait=3", "data.simulated_gait is 3, expected a section"),
        ("data.simulated_gait.subjects=[]", "data.simulated_gait.subjects is [], expected a name"),
        ("data.simulated_gait.subjects=X9", "simulated_gait: subject 'X9', expected S1 ... S5"),
        ("data.simulated_gait.steps=[5,3]", "simulated_gait: steps=[5, 3], expected [shortest"),
        ("data.simulated_gait.sampling_rate_hz=0", "data.simulated_gait.sampling_rate_hz is 0"),
        (
            "data.simulated_gait.treadmill_duration_s=5",
            "treadmill_duration_s is 5, expected a num",
        ),
        ("calibration=foo", "calibration is 'foo', expected one of auto, leg"),
        ("select.subject=[]", "select.subject is [], expected a name or a list of names or null"),
        ("select=S1", "select is 'S1', expected a section with the keys subject, condition, trial"),
        ("evaluation.confidence=1", "evaluation.confidence is 1, expected a number above 0 and be"),
        ("method.giof.static_offset_deg_s=[1]", "method"),
        ("+method.giof.x=1", "method.giof.x: unknown key, the closest is method.giof."),
        ("report=null", "report is null, expected a section"),
        ("seed=${x}", "seed"),
        ("seed=${seed}", "seed"),
        ("data_root='~no_such_user/x'", "data_root: '~no_such_user/x' cannot be a path"),
    ],
)
def test_one_line_names_key_value_and_allowed_values(compose_checked, override, line):
    with pytest.raises((UserError, OmegaConfBaseException)) as refusal:
        compose_checked("benchmark", "methods=[narx,giof]", *readable([override]))
    said = str(refusal.value)
    assert line in said
    if isinstance(refusal.value, UserError):
        assert "\n" not in said


@pytest.mark.parametrize(
    "override",
    [
        "data.simulated_gait.trials_per_condition=1000000000",
        "data.simulated_gait.treadmill_duration_s=1e9",
        "data.simulated_gait.treadmill_duration_s=900000",
        "data.simulated_gait.sampling_rate_hz=1e9",
    ],
)
def test_impossible_computations_are_refused(compose_checked, override):
    with pytest.raises(UserError, match="expected"):
        compose_checked("train", override)


@pytest.mark.parametrize(
    ("key", "given", "meant"),
    [
        ("select.trial", "1", ["1"]),
        ("select.subject", "7", ["7"]),
        ("select.subject", "[7,S1]", ["7", "S1"]),
        ("select.condition", "1.5", ["1.5"]),
        ("training.segments", "thigh_left", ["thigh_left"]),
        ("data_root", "3", "3"),
        ("split.subject", "3", "3"),
        ("model.odd", "no", False),
        ("model.odd", "off", False),
        ("model.odd", "Yes", True),
        ("data.simulated_gait.ideal", "on", True),
        ("data.simulated_gait.subjects", "S1", ["S1"]),
    ],
)
def test_a_number_is_a_name_and_a_word_is_true_or_false(compose_checked, key, given, meant):
    cfg = compose_checked("train", "split=one_window", f"{key}={given}")
    assert OmegaConf.select(cfg, key) == meant


def test_one_seed_sets_all_and_each_can_be_set_separately(compose_checked):
    def seeds(*overrides):
        cfg = compose_checked("train", "split=one_window", *overrides)
        assert cfg.data.simulated_gait.seed == cfg.data.seed
        return cfg.data.seed, cfg.split.seed, cfg.training.seed

    assert seeds() == (0, 0, 0)
    assert seeds("seed=4") == (4, 4, 4)
    assert seeds("training.seed=4") == (0, 0, 4)
    assert seeds("split.seed=4") == (0, 4, 0)
    assert seeds("seed=2", "data.seed=1") == (1, 2, 2)
