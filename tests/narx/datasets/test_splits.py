"""Splits: no subject is in both training and test set, and each is tested exactly once."""

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.datasets import splits
from narx.errors import UserError


def index_of(subjects, conditions, source="walks"):
    rows = [
        {"source": source, "subject": s, "condition": c, "trial": "1", "device": c[:1]}
        for s in subjects
        for c in conditions
    ]
    return pd.DataFrame(rows)


def overlaps(fold):
    return [
        (training, test)
        for training in fold.training
        for test in fold.test
        if training.key == test.key
        and test.start_s < training.stop_s
        and training.start_s < test.stop_s
    ]


@settings(deadline=None, max_examples=20)
@given(n_subjects=st.integers(2, 5), n_conditions=st.integers(1, 3))
def test_leave_one_out_tests_everyone_once_without_training_on_them(n_subjects, n_conditions):
    index = index_of([f"s{k}" for k in range(n_subjects)], [f"c{k}" for k in range(n_conditions)])
    folds = list(splits.leave_one_out(index))
    tested = [part.key for fold in folds for part in fold.test]
    assert sorted(tested) == sorted(map(tuple, index.iloc[:, :4].to_numpy()))
    for fold in folds:
        assert not {p.subject for p in fold.training} & {p.subject for p in fold.test}
        assert len(fold.training) + len(fold.test) == len(index)


def test_leave_one_device_out():
    index = index_of(["a", "b"], ["slow", "fast"])
    folds = list(splits.leave_one_out(index, column="device"))
    assert [fold.name for fold in folds] == ["without_device_s", "without_device_f"]


def test_within_trial_parts_do_not_overlap():
    folds = list(splits.within_trial(index_of(["a", "b"], ["slow"])))
    assert len(folds) == 2
    assert not [pair for fold in folds for pair in overlaps(fold)]


def test_within_trial_tests_what_comes_after_training():
    (fold,) = splits.within_trial(index_of(["a"], ["slow"]), training_s=10.0, skip_s=3.0)
    assert [(part.start_s, part.stop_s) for part in fold.training] == [(3.0, 13.0)]
    assert [(part.start_s, part.stop_s) for part in fold.test] == [(13.0, float("inf"))]


def test_one_window_is_ten_seconds_of_one_walk_and_seeded():
    index = index_of([f"s{k}" for k in range(5)], ["slow", "normal", "fast"])
    first, again, other = (
        next(iter(splits.one_window(index, condition="normal", seed=seed))) for seed in (1, 1, 2)
    )
    assert first == again != other
    (training,) = first.training
    assert training.condition == "normal"
    assert training.stop_s - training.start_s == pytest.approx(10.0)
    assert first.validation[0].start_s == training.stop_s
    assert len(first.test) == 15


def test_one_window_lies_within_a_trial_of_known_length():
    index = index_of(["s"], ["normal"]).assign(duration_s=60.0)
    starts = []
    for seed in range(20):
        (fold,) = splits.one_window(index, seed=seed)
        assert fold.validation[0].stop_s <= 60.0
        starts.append(fold.training[0].start_s)
    assert 20.0 <= min(starts) < 23.0
    assert 27.0 < max(starts) <= 30.0
    unknown, long = (index.assign(duration_s=value) for value in (float("nan"), 280.0))
    assert list(splits.one_window(unknown)) == list(splits.one_window(long))
    (only,) = splits.one_window(index.assign(duration_s=50.0))
    assert (only.training[0].start_s, only.validation[0].stop_s) == (20.0, 50.0)
    with pytest.raises(UserError, match=r"^split: .*/s/normal/.* lasts 45 s, expected earliest_s"):
        list(splits.one_window(index.assign(duration_s=45.0)))


@pytest.mark.parametrize(
    ("split", "keywords", "message"),
    [
        (splits.leave_one_out, {"column": "shoe"}, "no column 'shoe'"),
        (splits.leave_one_out, {"column": "trial"}, "needs at least two"),
        (splits.one_window, {"subject": "nobody"}, "no trial with subject=nobody"),
    ],
)
def test_what_cannot_be_split_is_refused(split, keywords, message):
    with pytest.raises(UserError, match=message):
        list(split(index_of(["a", "b"], ["slow"]), **keywords))


def test_automatic_choice():

    def names(index, **keywords):
        return [fold.name for fold in splits.automatic(index, **keywords)]

    simulated = index_of(["S1"], ["normal"], source="simulated_gait")
    assert names(simulated)[0].startswith("S1_normal_")
    assert names(index_of(["a", "b"], ["x"])) == ["without_subject_a", "without_subject_b"]
    assert names(index_of(["a"], ["x"])) == ["pretrained"]
    assert names(index_of(["a", "b"], ["x"]), testing=False) == ["everything"]
