"""Training as printed by Tham et al.: random draws, trained weights, and variants."""

import numpy as np
import pandas as pd
import pytest
import torch
from omegaconf import OmegaConf

from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.experiments.as_printed import check_overrides, draw_window, sequence_of, train_as_printed
from narx.experiments.configuration.schemas import PrintedVariant
from narx.experiments.tables.as_printed import as_printed_table


@pytest.fixture(scope="module")
def walks():
    source = SimulatedGait(
        subjects=("S1", "S2"), conditions=("normal",), treadmill_duration_s=25, sampling_rate_hz=100
    )
    return [(trial, calibrate(trial, "functional")) for trial in source]


def variant(**changes):
    return OmegaConf.create(PrintedVariant(**changes).model_dump())


@pytest.fixture
def sequence(walks):
    _, segment, window = draw_window(walks, 10.0, 5.0, np.random.default_rng(0))
    return sequence_of(segment, window, segment.reference_angles_rad)


def trained(sequence, **changes):
    return train_as_printed(sequence, variant(**changes), 3, 25, np.random.default_rng(1))


def test_windows_are_of_all_walks_and_legs_and_within_them(walks):
    drawn = [draw_window(walks, 10.0, 5.0, np.random.default_rng(k)) for k in range(60)]
    assert {trial.subject for trial, *_ in drawn} == {"S1", "S2"}
    assert {segment.signals.segment for _, segment, _ in drawn} == {
        "thigh_right", "thigh_left", "shank_right", "shank_left",
    }  # fmt: skip
    for trial, _, window in drawn:
        assert window.stop - window.start == 1000
        assert window.start >= 500
        assert window.stop <= trial.n_samples
    with pytest.raises(UserError, match=r"window_s: .* lasts 25.* s, expected at least 35 s"):
        draw_window(walks, 30.0, 5.0, np.random.default_rng(0))


def test_the_errors_are_those_of_the_network(sequence):
    """One step ahead and in closed loop, by hand from the weights."""
    found = trained(sequence)
    model = found.method.model
    assert not model.odd
    assert not model.coupled
    scaled, structure = model.normalisation, model.structure
    w = model.weights.detach().numpy()
    w1, b1, w2, b2 = w[structure.w1].reshape(3, 4), w[structure.b1], w[structure.w2], w[-1]
    rates = sequence.signals.axis_rates_rad_s[:, 0]
    v = (rates - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s
    p = (sequence.target_rad[:, 0] - scaled.angle_offset_rad) / scaled.angle_scale_rad
    assert v.min() == pytest.approx(-1.0)
    assert p.max() == pytest.approx(1.0)

    def step(*features):
        return b2 + np.tanh(w1 @ features + b1) @ w2

    ahead = [step(v[k], v[k - 1], p[k - 1], p[k - 2]) - p[k] for k in range(2, len(p))]
    rms = np.sqrt(np.mean(np.square(ahead))) * np.degrees(scaled.angle_scale_rad)
    assert found.one_step_deg == pytest.approx(rms, rel=1e-6)
    state, errors = [0.0, 0.0, 0.0], []
    for k in range(len(p)):
        angle = step(v[k], *state)
        state = [v[k], angle, state[1]]
        errors.append(angle - p[k])
    rms = np.sqrt(np.mean(np.square(errors))) * np.degrees(scaled.angle_scale_rad)
    assert found.closed_loop_deg == pytest.approx(rms, rel=1e-6)


def test_a_variant_changes_one_thing(sequence):
    printed = trained(sequence)
    weights = printed.method.model.weights
    again, own = trained(sequence), trained(sequence, axis_scaling="own")
    assert torch.equal(again.method.model.weights, weights)
    assert torch.equal(own.method.model.weights, weights)
    assert own.method.axis_scaling == "own"
    closed = trained(sequence, curriculum=("open", "closed"))
    assert closed.closed_loop_deg < printed.closed_loop_deg
    assert closed.one_step_deg > printed.one_step_deg
    best = trained(sequence, restarts=8)
    assert best.closed_loop_deg <= printed.closed_loop_deg
    for changes in ({"prior_deg2": 1.0}, {"starts": "leaky_integrator"}):
        assert not torch.equal(trained(sequence, **changes).method.model.weights, weights)


def test_the_table_has_quartiles_over_draws_and_the_printed_values():
    draws = pd.DataFrame(
        {
            "variant": "as printed",
            "draw": range(5),
            "neurons": [3, 4, 4, 3, 4],
            "one_step_deg": 0.001,
            "closed_loop_deg": [1.0, 2.0, 3.0, 11.0, 50.0],
            "knee_sagittal_deg": [5.0, 6.0, 7.0, 8.0, 9.0],
            "knee_frontal_deg": 1.0,
            "knee_transverse_deg": 1.0,
        }
    )
    table = as_printed_table(draws)
    assert table.frame.loc["as printed", "closed loop, own window"] == "3.0 [2.0, 11.0]"
    assert table.frame.loc["as printed", "own window beyond 10°"] == "2 of 5"
    assert table.frame.loc["as printed", "knee as good as print"] == "0 of 5"
    good = as_printed_table(draws.assign(knee_sagittal_deg=[2.0, 2.6, 2.8, 8.0, 9.0]))
    assert good.frame.loc["as printed", "knee as good as print"] == "2 of 5"
    assert table.frame.loc["Tham et al.", "knee sagittal"] == "2.7"
    assert "3 in 2, 4 in 3 draws" in table.note


@pytest.mark.slow
def test_the_command_leaves_draws_and_a_table(run_command):
    status, out, err, directory = run_command(
        "as_printed", "draws=2", "subjects=[S1]", "duration_s=20", "sampling_rate_hz=100",
        "iterations=5", "~variants", "+variants={printed: {}, own: {axis_scaling: own}}",
    )  # fmt: skip
    assert status == 0, err
    results = pd.read_csv(directory / "as_printed.csv")
    assert list(results["variant"]) == ["printed", "own"] * 2
    assert np.isfinite(results["knee_sagittal_deg"]).all()
    assert "| printed" in out


@pytest.mark.parametrize(
    "override",
    ["data=broad", "methods=[vqf]", "++choose=false", "+select.subject=S1", "debug=tiny"],
)
def test_keys_of_the_comparison_are_refused_beside_it(run_command, override):
    status, _, err, directory = run_command("benchmark", "experiment=tham_as_printed", override)
    assert status == 2
    key = override.lstrip("+~").partition("=")[0]
    assert err.splitlines()[-1] == (
        f"error: {key}: has no effect with experiment=tham_as_printed, expected as_printed.* or "
        "one of experiment, profile, seed"
    )
    assert not (directory / "as_printed.csv").exists()


def test_its_own_keys_are_accepted():
    check_overrides(["experiment=tham_as_printed", "as_printed.draws=2", "seed=1", "profile=true"])
