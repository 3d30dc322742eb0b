"""Names from files, folders and settings are data: none of them leads out of its folder."""

import os
from pathlib import Path

import matplotlib.figure
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from omegaconf import OmegaConf

from narx.datasets.segment_names import segment_of
from narx.errors import UserError
from narx.experiments.predictions import bulk
from narx.experiments.reports import summary
from narx.experiments.tensorboard_log import TensorBoardLog
from narx.files import safe_name

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:tensorboard")

HOSTILE = [
    "../../../escaped", "..", ".", "", "/etc/passwd", "a/../../b", "C:\\windows\\x", "\\\\host\\x",
    "a\x00b", "line\nbreak", "\x1b[31m", "CON", "nul.txt", "com1", "LPT9.csv", "x" * 300,
    "歩" * 300, "\ud800", " .hidden. ", "-rf", "~root", "$HOME", "a:b", "‮evil", "é" * 89,
]  # fmt: skip
names = st.sampled_from(HOSTILE) | st.text(max_size=300)
quick = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def is_safe(name: str) -> bool:
    stem = name.split(".")[0].lower()
    return (
        name == os.path.basename(name)
        and name not in ("", ".", "..")
        and "\\" not in name
        and not name.startswith(".")
        and name == name.strip(". ")
        and name.isprintable()
        and len(os.fsencode(name)) <= 200
        and stem not in {"con", "prn", "aux", "nul", "com1", "lpt9"}
    )


@settings(max_examples=500, deadline=None)
@given(names)
@example("thigh_right")
def test_a_safe_name_is_one_and_stays_itself(name):
    safe = safe_name(name)
    assert is_safe(safe)
    assert safe_name(safe) == safe
    assert is_safe(segment_of(name))


@pytest.mark.parametrize("name", ["thigh_right", "S1 normal", "läufer", "t1", "a.b-c+d"])
def test_an_ordinary_name_is_kept(name):
    assert safe_name(name) == name


def test_long_names_that_differ_at_their_end_stay_apart():
    assert safe_name("x" * 300 + "1") != safe_name("x" * 300 + "2")


def everything_below(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


@quick
@given(names)
def test_figures_stay_in_their_folder(tmp_path_factory, name):
    top = tmp_path_factory.mktemp("top")
    run = top / "a" / "run"
    summary.save_figures({f"waveforms_{name}": matplotlib.figure.Figure((1, 1))}, run)
    (written,) = everything_below(top)
    assert written.parent == run / "figures"
    assert is_safe(written.name)


@quick
@given(names)
def test_the_log_of_a_fold_stays_below_that_of_its_run(tmp_path_factory, name):
    top = tmp_path_factory.mktemp("top")
    with TensorBoardLog(top / "a" / "log") as log, log.of_fold(safe_name(name, 120)) as fold:
        fold.iteration(0, {"cost": 1.0})
    assert all(top / "a" / "log" in path.parents for path in everything_below(top))


file_names = st.sampled_from(["a b.csv", "歩.csv", "-rf.csv", "#.csv", "é" * 125 + ".csv"])


@quick
@given(file_names, st.sampled_from([".", "sub", "sub/deeper"]))
def test_angles_of_many_files_stay_below_the_output(tmp_path_factory, name, folder):
    root = tmp_path_factory.mktemp("in")
    (root / folder).mkdir(parents=True, exist_ok=True)
    (root / folder / name).touch()
    out = root / "out"
    (job,) = bulk.jobs_of_files(OmegaConf.create({"input": str(root), "format": "csv"}), out)
    target = job.target
    target.parent.mkdir(parents=True)
    target.touch()
    assert out in target.resolve().parents


def test_a_pattern_that_climbs_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"has '\.\.' after a wildcard"):
        bulk.jobs_of_files(
            OmegaConf.create({"input": str(tmp_path / "*" / ".." / ".." / "x.csv")}),
            tmp_path / "out",
        )
