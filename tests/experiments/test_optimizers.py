"""The comparison of optimisers: the same data for all, and a table that can be read back."""

import numpy as np
import pandas as pd
import pytest

from narx.experiments.optimizers import plain_arrays

TINY = (
    "optimizers=[levenberg_marquardt,lbfgs]",
    'overrides=["optimizer.restarts=2","optimizer.iterations=15"]',
)


def test_plain_arrays_are_seeded_and_their_rates_are_those_of_their_angles():
    one, again, other = plain_arrays(1), plain_arrays(1), plain_arrays(2)
    assert len(one) == 3
    for a, b, c in zip(one, again, other, strict=True):
        np.testing.assert_array_equal(a.target_rad, b.target_rad)
        assert not np.allclose(a.target_rad, c.target_rad)
        rates = np.gradient(a.target_rad, 0.01, axis=0)
        error = a.signals.axis_rates_rad_s - rates
        assert np.abs(error.mean(axis=0)).max() < 0.03
        assert error.std(axis=0) == pytest.approx(0.02, rel=0.1)


@pytest.mark.slow
def test_every_optimiser_and_kind_of_data_has_a_row(run_command):
    gait = (
        "data.simulated_gait.subjects=[S1]",
        "data.simulated_gait.conditions=[normal]",
        "data.simulated_gait.treadmill_duration_s=30",
        "data.simulated_gait.sampling_rate_hz=100",
        "split=everything",
    )
    kinds = (f"data.simulated_gait={list(gait)}".replace("'", '"'), "~data.pocket_walks")
    status, out, err, directory = run_command("optimizers", *TINY, *kinds)
    assert status == 0, err
    table = pd.read_csv(directory / "optimizers.csv", index_col=[0, 1])
    assert list(table.index) == [
        (kind, name)
        for kind in ("simulated gait", "plain arrays")
        for name in ("levenberg_marquardt", "lbfgs")
    ]
    assert (table["Held-out error (°)"] < 10.0).all()
    # two starts, two stages, each with its first evaluation
    counts = table["Cost evaluations"].xs("levenberg_marquardt", level="Optimiser")
    assert (counts <= 2 * 2 * (15 + 1)).all()
    assert (counts > 4).all()
    assert (table["CPU time (s)"] > 0).all()
    assert (directory / "optimizers.md").read_text() in out


def test_a_wrong_override_names_the_optimiser_and_the_data(run_command):
    status, _, err, _ = run_command("optimizers", 'overrides=["optimizer.restarts=0"]')
    assert status == 2
    assert "optimizers levenberg_marquardt, data.simulated_gait: optimizer.restarts is 0" in err
    assert len(err.strip().splitlines()) == 1


def test_a_number_is_no_optimiser(run_command):
    status, _, err, _ = run_command("optimizers", "optimizers=9999")
    assert status == 2
    assert "optimizers 9999, data.simulated_gait: optimizer is 9999, expected the name of" in err
