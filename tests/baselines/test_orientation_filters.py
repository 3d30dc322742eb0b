"""The adapters against direct calls of the libraries."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import narx.baselines.parameters
from narx import baselines
from narx.baselines.orientation_filter import AnglesOneByOne
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import angles_from_orientation, axis_rates, gyroscope_xyz

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}


@pytest.fixture
def noisy(motion):
    rng = np.random.default_rng(7)
    walk = motion("half_turn", 100.0, 30.0).signals
    return replace(
        walk,
        axis_rates_rad_s=walk.axis_rates_rad_s + rng.normal(0.01, 0.02, (walk.n_samples, 3)),
        specific_force_m_s2=walk.specific_force_m_s2 + rng.normal(0, 0.5, (walk.n_samples, 3)),
        initial_angles_rad=None,
    )


def test_gyroscope_xyz_undoes_axis_rates():
    rates = np.random.default_rng(0).normal(size=(20, 3))
    np.testing.assert_array_equal(gyroscope_xyz(axis_rates(rates)), rates)
    np.testing.assert_array_equal(axis_rates(gyroscope_xyz(rates)), rates)


def assert_same_angles(angles, quaternion):
    direct = angles_from_orientation(quaternion)
    np.testing.assert_allclose(angles[:, :2], direct[:, :2], atol=1e-9)
    np.testing.assert_allclose(angles[:, 2], direct[:, 2] - direct[0, 2], atol=1e-9)


@pytest.mark.parametrize("offline", [False, True])
def test_vqf_is_vqf(noisy, offline):
    vqf = pytest.importorskip("vqf")
    gyroscope, accelerometer = gyroscope_xyz(noisy.axis_rates_rad_s), noisy.specific_force_m_s2
    if offline:
        result = vqf.offlineVQF(gyroscope, accelerometer, None, 0.01)
    else:
        result = vqf.VQF(0.01).updateBatch(gyroscope, accelerometer)
    assert_same_angles(METHODS["vqf"](offline=offline).estimate(noisy), result["quat6D"])


def test_vqf_offline_has_the_parameters_too_and_none_is_taken_for_another(noisy):
    vqf = pytest.importorskip("vqf")
    online, offline, fast = (
        METHODS["vqf"](**parameters)
        for parameters in ({}, {"offline": True}, {"offline": True, "tau_acc_s": 0.7})
    )
    assert (online.causal, offline.causal) == (True, False)
    gyroscope, accelerometer = gyroscope_xyz(noisy.axis_rates_rad_s), noisy.specific_force_m_s2
    # one after another on one recording, of which the latest orientation is kept
    for method, parameters in ((offline, {}), (fast, {"tauAcc": 0.7})):
        result = vqf.offlineVQF(gyroscope, accelerometer, None, 0.01, parameters)
        assert_same_angles(method.estimate(noisy), result["quat6D"])
    result = vqf.VQF(0.01).updateBatch(gyroscope, accelerometer)
    assert_same_angles(online.estimate(noisy), result["quat6D"])


@pytest.mark.parametrize("name", ["madgwick", "mahony"])
def test_ahrs_sample_by_sample_is_the_same(noisy, name):
    short = noisy.select(slice(0, 500))
    inputs = np.hstack([short.axis_rates_rad_s, short.specific_force_m_s2])
    found = OrientationStream(METHODS[name](), 100.0).update_block(inputs).angles_rad
    np.testing.assert_allclose(found, METHODS[name]().estimate(short), atol=1e-9)


@pytest.mark.parametrize(("motion_bias", "rest_bias"), [(False, False), (True, False)])
def test_vqf_parameters_reach_the_library(noisy, motion_bias, rest_bias):
    vqf = pytest.importorskip("vqf")
    direct = vqf.VQF(
        0.01, tauAcc=0.7, motionBiasEstEnabled=motion_bias, restBiasEstEnabled=rest_bias
    )
    result = direct.updateBatch(gyroscope_xyz(noisy.axis_rates_rad_s), noisy.specific_force_m_s2)
    method = METHODS["vqf"](
        tau_acc_s=0.7, motion_bias_estimation=motion_bias, rest_bias_estimation=rest_bias
    )
    angles = method.estimate(noisy)
    assert_same_angles(angles, result["quat6D"])
    inputs = np.hstack([noisy.axis_rates_rad_s, noisy.specific_force_m_s2])
    one_by_one = OrientationStream(method, 100.0).update_block(inputs).angles_rad
    # as often half a turn away as the heading of one sample is
    np.testing.assert_allclose(np.sin(one_by_one), np.sin(angles), atol=1e-9)


@pytest.mark.parametrize("rest_bias", [False, True])
def test_vqf_estimates_the_bias_at_rest_only_if_asked(motion, rest_bias):
    """One degree per second, which it finds within seconds of rest, or turns with."""
    vqf = pytest.importorskip("vqf")
    still = motion("still", 100.0, 20.0).signals
    biased = replace(still, axis_rates_rad_s=still.axis_rates_rad_s + np.deg2rad(1.0))
    direct = vqf.VQF(0.01, restBiasEstEnabled=rest_bias)
    result = direct.updateBatch(gyroscope_xyz(biased.axis_rates_rad_s), biased.specific_force_m_s2)
    angles = METHODS["vqf"](rest_bias_estimation=rest_bias).estimate(biased)
    assert_same_angles(angles, result["quat6D"])
    drift_deg_s = abs(np.rad2deg(angles[-1, 2] - angles[-501, 2])) / 5.0
    assert (drift_deg_s < 0.1) == rest_bias


@pytest.mark.parametrize(
    ("name", "parameters", "library_parameters"),
    [
        ("madgwick", {}, {}),
        ("madgwick", {"gain": 0.1}, {"gain": 0.1}),
        ("mahony", {}, {}),
        (
            "mahony",
            {"proportional_gain": 0.5, "integral_gain": 0.1},
            {"k_P": 0.5, "k_I": 0.1},
        ),
    ],
)
def test_ahrs_is_ahrs(noisy, name, parameters, library_parameters):
    filters = pytest.importorskip("ahrs").filters
    short = noisy.select(slice(0, 1500))
    direct = getattr(filters, name.capitalize())(
        gyr=gyroscope_xyz(short.axis_rates_rad_s),
        acc=short.specific_force_m_s2,
        frequency=100.0,
        **library_parameters,
    )
    assert_same_angles(METHODS[name](**parameters).estimate(short), direct.Q)


@pytest.mark.parametrize("name", ["madgwick", "mahony"])
def test_ahrs_starts_from_known_angles(motion, name):
    start = np.array([0.3, -0.2, 5.0])
    signals = motion("still", duration_s=1.0).changed(initial_angles_rad=start).signals
    angles = METHODS[name]().estimate(signals)
    np.testing.assert_allclose(angles[0], start, atol=1e-12)
    stream = OrientationStream(METHODS[name](), signals.sampling_rate_hz, initial_angles_rad=start)
    inputs = np.hstack([signals.axis_rates_rad_s, signals.specific_force_m_s2])
    np.testing.assert_allclose(stream.update_block(inputs).angles_rad, angles, atol=1e-9)


@pytest.mark.parametrize("name", ["vqf", "madgwick", "mahony"])
def test_the_true_angles_come_out(motion, name):
    if name == "vqf":
        pytest.importorskip("vqf")
    walk = motion("half_turn", 200.0, 30.0)
    late = walk.time_s > 10
    error = np.rad2deg(METHODS[name]().estimate(walk.signals) - walk.angles_rad)[late]
    assert np.abs(error[:, :2]).max() < 1.5
    # half a turn of heading is followed, not lost
    assert np.abs(error[:, 2]).max() < 5.0


def test_one_by_one_the_heading_is_continuous_beyond_half_a_turn():
    heading_rad = 0.1 * np.arange(200)  # three turns
    turn = Rotation.from_euler("Z", heading_rad[:, None]).as_quat(scalar_first=True)
    angles_of = AnglesOneByOne(np.array([0.0, 0.0, 0.3]))
    found = [angles_of(quaternion)[2] for quaternion in turn]
    np.testing.assert_allclose(found, 0.3 + heading_rad, atol=1e-9)


def test_a_missing_library_is_one_clear_line(monkeypatch):
    def missing(module):
        raise ModuleNotFoundError(f"No module named {module!r}", name=module)

    monkeypatch.setattr(narx.baselines.parameters.importlib, "import_module", missing)
    with pytest.raises(MethodNotApplicableError) as refusal:
        narx.baselines.parameters.optional_library("vqf", "vqf")
    assert str(refusal.value) == (
        "method vqf needs the package 'vqf', which is not installed: "
        "pip install 'narx-orientation[filters]'"
    )


def test_a_library_that_is_broken_in_itself_is_not_called_missing(monkeypatch):
    def broken(module):
        raise ModuleNotFoundError("No module named 'numpy'", name="numpy")

    monkeypatch.setattr(narx.baselines.parameters.importlib, "import_module", broken)
    with pytest.raises(ModuleNotFoundError):
        narx.baselines.parameters.optional_library("vqf", "vqf")


def test_offline_vqf_does_not_stream():
    pytest.importorskip("vqf")
    with pytest.raises(MethodNotApplicableError, match="offline=true needs the whole recording"):
        METHODS["vqf"](offline=True).recursion(100.0, 1, None)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("vqf", {"tau_acc_s": 0.0}, "tau_acc_s is 0.0"),
        ("madgwick", {"gain": -1.0}, "gain is -1.0"),
        ("mahony", {"integral_gain": np.nan}, "integral_gain is nan"),
    ],
)
def test_wrong_parameters_are_one_clear_line(name, parameters, message):
    if name == "vqf":
        pytest.importorskip("vqf")
    with pytest.raises(UserError, match=message):
        METHODS[name](**parameters)


@pytest.mark.parametrize("name", ["madgwick", "mahony"])
def test_treatments_of_the_heading_share_the_orientation(motion, monkeypatch, name):
    """One run for all, unless the recording or a gain is another one."""
    made = METHODS[name]
    runs = []
    original = made._orientation
    monkeypatch.setattr(
        made, "_orientation", lambda self, signals: runs.append(1) or original(self, signals)
    )
    walk, other = (motion("walking", duration_s=duration).signals for duration in (10.0, 11.0))
    own = made().estimate(walk)
    zero = made(heading="zero").estimate(walk)
    assert len(runs) == 1
    np.testing.assert_array_equal(own[:, :2], zero[:, :2])
    assert not zero[:, 2].any()
    own[:] = 9.0  # the caller's own array
    np.testing.assert_array_equal(made(heading="zero").estimate(walk), zero)
    assert len(runs) == 1
    gain = {"madgwick": "gain", "mahony": "integral_gain"}[name]
    assert not np.array_equal(made(**{gain: 0.01}).estimate(walk)[:, :2], zero[:, :2])
    made().estimate(other)
    assert len(runs) == 3
