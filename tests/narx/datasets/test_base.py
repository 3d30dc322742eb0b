"""Filtering and lazy loading, which every source inherits."""

import numpy as np
import pandas as pd
import pytest

from narx.datasets.base import TrialSource
from narx.errors import UserError
from narx.recordings.trial import ImuRecording, Trial


class _Six(TrialSource):
    name = "six"

    def __init__(self) -> None:
        self.loaded: list[str] = []

    def _list_trials(self) -> pd.DataFrame:
        return pd.DataFrame(
            [(s, c, t) for s in "AB" for c in ("slow", "fast") for t in "12"][:-2],
            columns=["subject", "condition", "trial"],
        )

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        self.loaded.append(subject + condition + trial)
        time = np.arange(3) / 10.0
        imu = ImuRecording("thigh", time, np.zeros((3, 3)), np.zeros((3, 3)))
        return Trial("six", subject, condition, trial, 10.0, {"thigh": imu})


def test_length_and_iteration_follow_the_index():
    source = _Six()
    names = [t.subject + t.condition + t.trial for t in source]
    index = source.index()
    assert len(source) == len(names) == 6
    assert names == (index.subject + index.condition + index.trial).tolist()


def test_iteration_is_lazy():
    source = _Six()
    next(iter(source))
    assert source.loaded == ["Aslow1"]


def test_select_filters_without_changing_the_original():
    source = _Six()
    some = source.select(subject="A", trial=["1"])
    assert some.index().condition.tolist() == ["slow", "fast"]
    assert len(some.select(condition="fast")) == 1
    assert len(source) == 6


def test_unknown_names_list_the_known_ones():
    with pytest.raises(UserError, match="no subject 'C'; known are A, B"):
        _Six().select(subject=["A", "C"])
    with pytest.raises(UserError, match="no trial '9'; known are 1, 2"):
        _Six().load("A", "slow", "9")


def test_a_name_may_be_a_number():
    assert _Six().load("A", "slow", 1).trial == "1"


def test_known_names_that_never_meet():
    with pytest.raises(UserError, match="together"):
        _Six().select(subject="B", condition="fast")


def test_changing_the_index_does_not_change_the_source():
    source = _Six()
    mine = source.index()
    mine.loc[0, "subject"] = "Z"
    assert source.index().subject[0] == "A"


@pytest.mark.parametrize("trial", [1, [1], "1"])
def test_a_number_on_the_command_line_is_a_name(trial):
    assert _Six().select(trial=trial).index().trial.unique().tolist() == ["1"]
