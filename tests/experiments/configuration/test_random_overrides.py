"""Overrides drawn at random from the schemas: each ends with a result or with one line.

A twentieth is drawn in continuous integration; all of them:

    NARX_RANDOM_OVERRIDES=500 pytest tests/experiments/configuration/test_random_overrides.py
"""

import os
import random
import time
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import pytest
from hydra import compose, initialize_config_module
from omegaconf import OmegaConf
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from narx.errors import UserError
from narx.experiments.configuration import checked_configuration, composition_mistake
from narx.experiments.configuration.components import schema_for
from narx.experiments.configuration.schemas import SCHEMAS
from narx.experiments.overrides import readable

N_DRAWN = int(os.environ.get("NARX_RANDOM_OVERRIDES", "25"))
LONGEST_REFUSAL_S = 5.0

HOSTILE = (
    "abc", "''", "' '", "null", "true", "no", "-1", "0", "-0", "1.5", "1e400", "-1e400", "nan",
    "inf", "1e300", "1e-320", "99999999999999999999", "9" * 5000, "[]", "[1]", "[1,2,3]",
    "[null]", "[[1]]", "{}", "{a: 1}", "{a: {b: [1]}}", "${x}", "${seed}", "${oc.env:NO_SUCH}",
    "'${'", "läufer", "歩行", "'a b'", "a=b", "../../x", "/dev/null", "/", "x" * 3000, "'\\n'",
    "'\\x00'", "0x10", "1_000", "١", "[" * 300 + "]" * 300, "a,b", "range(3)", "yes", "\u202e",
)  # fmt: skip
GROUPS = ("data", "model", "optimizer", "teacher", "split", "experiment", "method", "report")
NAMES = {
    "subjects": ("S1", "S5", "V3", "[S1,V2]"),
    "subject": ("S1", "null"),
    "conditions": ("normal", "[slow,normal]", "null"),
    "condition": ("normal", "null"),
    "trial": ("1", "[1]"),
    "segments": ("thigh_right", "[thigh_right,shank_right]"),
    "methods": ("giof", "[narx]", "[vqf,zero]", "[mahony,madgwick,gyro_integration]"),
    "axes": ("[sagittal]", "[sagittal,frontal]"),
    "curriculum": ("[open]", "[open,5,closed]", "[closed]"),
    "column": ("subject", "condition"),
}
REQUIRED = {"export": ["output=narx.pt"], "predict": ["input=walk.csv", "output=angles.csv"]}
# all small, so that a result comes soon
SMALL = {
    "train": [
        "data.simulated_gait.subjects=[S1]",
        "data.simulated_gait.conditions=[normal]",
        "data.simulated_gait.treadmill_duration_s=30",
        "data.simulated_gait.sampling_rate_hz=50",
        "data.simulated_gait.segments=[thigh_right,shank_right]",
        "prepared.limit_gb=0",
        "split=everything",
        "optimizer.restarts=1",
        "optimizer.iterations=3",
    ]
}
SMALL["benchmark"] = [*SMALL["train"], "split=pretrained"]
SMALL["as_printed"] = [
    "draws=2",
    "subjects=[S1]",
    "duration_s=30",
    "sampling_rate_hz=100",
    "iterations=3",
]
SMALL["optimizers"] = [
    "~data.pocket_walks",
    "~data.simulated_gait",
    "overrides=[optimizer.restarts=1,optimizer.iterations=3]",
]


def leaves(model, prefix=""):
    """Every key of a schema with its annotation."""
    for name, field in model.model_fields.items():
        key = f"{prefix}{field.alias or name}"
        annotation = Annotated[field.annotation, field]
        yield key, annotation
        for one in alternatives(annotation):
            if isinstance(one, type) and issubclass(one, BaseModel):
                yield from leaves(one, f"{key}.")


def alternatives(annotation):
    if get_origin(annotation) is Annotated:
        return alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [one for member in get_args(annotation) for one in alternatives(member)]
    return [annotation]


def limits(annotation):
    found = {}
    while get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
        for item in metadata:
            for constraint in [item, *(item.metadata if isinstance(item, FieldInfo) else ())]:
                for name in ("gt", "ge", "lt", "le"):
                    if getattr(constraint, name, None) is not None:
                        found[name] = getattr(constraint, name)
    return found


def allowed(rng, key, annotation):
    """A random value of the annotated type, as typed on the command line."""
    name = key.rpartition(".")[2]
    if name in NAMES:
        return rng.choice(NAMES[name])
    one = rng.choice(alternatives(annotation))
    bounds = limits(annotation)
    low = bounds.get("ge", bounds.get("gt", 0))
    if get_origin(one) is Literal:
        return str(rng.choice(get_args(one)))
    if one is bool:
        return rng.choice(["true", "false", "yes", "no", "on", "off", "True", "OFF"])
    if one is int:
        return str(int(low) + rng.choice([0, 1, 2, 5, 20]))
    if one is float:
        high = min(bounds.get("le", bounds.get("lt", 1e3)), 1e3)
        return f"{low + (high - low) * rng.choice([1e-6, 1e-3, 0.1, 0.5, 0.9]):.6g}"
    if one is NoneType:
        return "null"
    if get_origin(one) is tuple and Ellipsis not in get_args(one):
        return f"[{','.join(allowed(rng, '', a) for a in get_args(one))}]"
    return rng.choice(HOSTILE)


def draw(rng, command):
    """Overrides of one call: mostly one, sometimes three."""
    overrides = []
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        kind = rng.random()
        key, annotation = rng.choice(KEYS[command])
        if kind < 0.4:
            overrides.append(f"{key}={allowed(rng, key, annotation)}")
        elif kind < 0.75:
            overrides.append(f"{key}={rng.choice(HOSTILE)}")
        elif kind < 0.8:
            overrides.append(f"~{key}")
        elif kind < 0.85:
            overrides.append(f"+{key}={allowed(rng, key, annotation)}")
        elif kind < 0.9:
            overrides.append(f"++{key}{rng.choice(['.x', 's', ''])}={rng.choice(HOSTILE)}")
        elif kind < 0.95:
            sign, group = rng.choice(["", "", "+", "~"]), rng.choice(GROUPS)
            overrides.append(f"{sign}{group}={rng.choice([*HOSTILE, *OPTIONS])}")
        else:
            overrides.append(f"{key[:-1]}={allowed(rng, key, annotation)}")
    if rng.random() < 0.05:
        overrides.append(overrides[0])
    return overrides


def _composed(command):
    with initialize_config_module("narx.configs", version_base="1.3"):
        return compose(command, overrides=REQUIRED.get(command, []))


def _keys(command):
    values: Any = OmegaConf.to_container(_composed(command), resolve=True)
    return list(leaves(schema_for(SCHEMAS[command], values)))


KEYS = {command: _keys(command) for command in SCHEMAS}
OPTIONS = ("coupled", "tham_literal", "adam", "lbfgs", "one_window", "everything", "vqf",
           "reference", "tham_knee_angle", "within_trial", "[giof]", "motion_bids")  # fmt: skip
# the measurement of endurance has no settings but sizes
CHOSEN = [command for command in SCHEMAS if command != "endurance"]
DRAWN = [
    (command, tuple(draw(random.Random(number), command)))
    for number in range(N_DRAWN)
    for command in [random.Random(number).choice([*CHOSEN, "train", "benchmark"])]
]


# hours of computing, whatever is overridden: these are composed and checked, not run
ONLY_CHECKED = ("ablation", "benchmark_page", "error_budget", "speed")


def refusal(command, overrides):
    """The line with which a configuration is refused, or None."""
    try:
        with initialize_config_module("narx.configs", version_base="1.3"):
            cfg = compose(command, overrides=overrides)
        checked_configuration(cfg, command)
    except UserError as error:
        return str(error)
    except Exception as error:  # as the command does, before its job has begun
        return composition_mistake(error, command, overrides)
    return None


@pytest.mark.slow
@pytest.mark.parametrize(("command", "overrides"), DRAWN, ids=range(N_DRAWN))
def test_it_ends_with_a_result_or_with_one_line(
    run_command, monkeypatch, tmp_path, command, overrides
):
    monkeypatch.chdir(tmp_path)
    first = SMALL.get(command, REQUIRED.get(command, []))
    begun_s = time.process_time()  # process time, since wall time is unreliable on a busy machine
    if command in ONLY_CHECKED:
        line = refusal(command, readable([*first, *overrides]))
        assert line is None or "\n" not in line
        return
    status, out, err, _ = run_command(command, *first, *overrides)
    took_s = time.process_time() - begun_s
    assert status in (0, 2), err
    assert "Traceback" not in out + err
    if status == 2:
        lines = [line for line in err.splitlines() if line.startswith("error: ")]
        assert len(lines) == 1
        assert took_s < LONGEST_REFUSAL_S
