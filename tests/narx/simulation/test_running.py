"""Running: its curves, its timing, and orientations that agree with the rates."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.simulation.gait_curves import evaluate
from narx.simulation.running import bounce_m, running_curves

SHORT = {"subjects": ["S1"], "treadmill_duration_s": 14.0, "ideal": True}


def test_the_curves_are_those_of_the_figure():
    phase = np.linspace(0.0, 1.0, 400, endpoint=False)
    curves = running_curves(2.7)
    hip, knee = (np.degrees(evaluate(curves[name], phase)[:, 0]) for name in ("hip", "knee"))
    # Novacheck 1998: hip extends until after toe-off, knee bends by 90 degrees and more in swing
    assert (hip.max(), hip.min()) == (pytest.approx(51.0, abs=2.0), pytest.approx(-6.0, abs=2.0))
    assert 0.35 < phase[hip.argmin()] < 0.45
    assert knee.max() == pytest.approx(97.0, abs=3.0)
    assert 0.65 < phase[knee.argmax()] < 0.75
    assert knee[(phase > 0.1) & (phase < 0.2)].max() == pytest.approx(41.0, abs=3.0)


def test_the_body_is_lowest_in_the_middle_of_stance():
    phase = np.array([0.19, 0.44, 0.69])
    np.testing.assert_allclose(bounce_m(phase, 0.38)[:, 2], [-0.04, 0.04, -0.04])


def test_rates_integrate_to_the_true_orientation(integrated):
    source = SimulatedGait(conditions=["running"], segments=["thigh_right"], **SHORT)
    trial, truth = source.load("S1", "running", "1"), source.truth("S1", "running", "1")
    true = Rotation.from_quat(truth.sensor_wxyz["thigh_right"], scalar_first=True)
    rate = trial.imus["thigh_right"].gyroscope_rad_s
    found = integrated(rate, trial.sampling_rate_hz, true[1])
    assert (found.inv() * true[1:-1]).magnitude().max() < 1e-6
    strikes, offs = (trial.events[f"{name}_right"] for name in ("heel_strike", "toe_off"))
    strikes = strikes[strikes > 9.0]
    assert np.diff(strikes).mean() == pytest.approx(1.0 / 1.35, rel=0.1)
    stance = offs[np.searchsorted(offs, strikes[:-1])] - strikes[:-1]
    assert np.all(np.abs(stance / np.diff(strikes) - 0.38) < 0.03)
    assert 8.0 < source.index()["speed_km_h"][0] < 11.0


def test_running_is_simulated_on_request_only():
    assert "running" not in SimulatedGait().conditions
    with pytest.raises(UserError, match="no condition 'running'"):
        SimulatedGait(protocol="stand_walk_stand", conditions=["running"])
