"""Which rows a figure shows."""

import numpy as np

from narx.evaluation.comparison import Evaluated
from narx.experiments.figures.most_accurate import most_accurate


def _piece(errors_deg):
    time_s = np.arange(200) / 100.0
    reference = np.zeros((200, 3))
    estimates = {row: reference + np.deg2rad(error) for row, error in errors_deg.items()}
    return Evaluated(
        dataset="made_up",
        subject="A",
        condition="normal",
        trial="1",
        segment="knee_right",
        sampling_rate_hz=100.0,
        time_s=time_s,
        reference_rad=reference,
        estimates_rad=estimates,
        scored=np.ones(200, dtype=bool),
    )


def test_the_network_and_the_best_form_of_the_five_most_accurate_methods():
    errors = {
        "narx": 9.0, "vqf": 3.0, "vqf_heading_zero": 1.0, "vqf_same_chosen": 2.0, "madgwick": 4.0,
        "mahony": 5.0, "zero": 6.0, "constant": 7.0, "strapdown": 8.0,
    }  # fmt: skip
    rows = most_accurate([_piece(errors)])
    assert sorted(rows) == sorted(
        ["narx", "vqf_heading_zero", "madgwick", "mahony", "zero", "constant"]
    )


def test_a_row_without_a_finite_error_comes_last():
    rows = most_accurate([_piece({"giof": np.nan, "vqf": 50.0})])
    assert set(rows) == {"vqf", "giof"}
    many = {f"method_{k}": float(k) for k in range(6)} | {"giof": np.nan}
    assert "giof" not in most_accurate([_piece(many)])
