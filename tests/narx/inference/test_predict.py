from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from narx.errors import RecordingError, UserError
from narx.inference.checkpoint import Checkpoint, save
from narx.inference.predict import angles_from_gyroscope, predict
from narx.inference.start_up import StartUp
from narx.inference.tracker import PostureTracker
from narx.kinematics.segment_angles import mirror_angular_rate, mirror_vector
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording
from narx.training.initial_weights import leaky_integrator_weights

BIAS_RAD_S = np.radians([1.5, -0.8, 2.0])
MOUNTING = Rotation.from_euler("xyz", [50.0, -110.0, 20.0], degrees=True)


def checkpoint(duration_s, std=None):
    """A checkpoint. A start-up longer than the recording only integrates, so angles are known."""
    model = Narx(100.0, Normalisation(3.0, 0.5))
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        weights = 0.4 * torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)
        model.weights.copy_(weights * model.trainable)
    return Checkpoint(model, StartUp(duration_s=duration_s), error_std_rad=std)


INTEGRATING = checkpoint(120.0).method()
NETWORK = checkpoint(5.0).method()


def sensor_on(motion):
    """The recording of a sensor that is aligned with the segment."""
    sagittal, frontal, transverse = motion.signals.axis_rates_rad_s.T
    gyroscope = np.column_stack([-frontal, -sagittal, transverse])
    return ImuRecording("imu", motion.time_s, gyroscope, motion.signals.specific_force_m_s2)


def turned(recording, mounting):
    return replace(
        recording,
        gyroscope_rad_s=mounting.apply(recording.gyroscope_rad_s),
        accelerometer_m_s2=mounting.apply(recording.accelerometer_m_s2),
    )


@pytest.fixture(scope="module")
def walk(motion):
    """Stands for 4 s, walks, stands again."""
    return motion("stand_walk_stand")


def test_known_start_gives_the_true_angles(walk):
    result = predict(sensor_on(walk), INTEGRATING, frame="anatomical", start_pose="known")
    np.testing.assert_allclose(result.angles_rad, walk.angles_rad, atol=np.radians(0.05))


@pytest.mark.parametrize("method", [INTEGRATING, NETWORK])
def test_a_uniform_recording_gets_the_angles_of_the_method(walk, method):
    result = predict(
        sensor_on(walk), method, frame="anatomical", start_pose="known", remove_bias=False
    )
    np.testing.assert_allclose(result.angles_rad, method.estimate(walk.signals), atol=1e-9)


def test_smoothing_reaches_the_method(walk, tmp_path):
    network = checkpoint(5.0)
    save(network, tmp_path / "net.pt")
    recording = sensor_on(walk)
    smoothed, one = (
        angles_from_gyroscope(
            recording.gyroscope_rad_s,
            100.0,
            frame="anatomical",
            remove_bias=False,
            smoothing=smoothing,
            checkpoint=tmp_path / "net.pt",
        )
        for smoothing in (True, False)
    )
    unknown = replace(walk.signals, initial_angles_rad=None)
    np.testing.assert_allclose(smoothed, network.method(True).estimate(unknown), atol=1e-9)
    assert np.abs(smoothed - one).max() > 1e-3


def test_left_leg_is_the_mirror_image(walk):
    right = sensor_on(walk)
    left = replace(
        right,
        gyroscope_rad_s=mirror_angular_rate(right.gyroscope_rad_s),
        accelerometer_m_s2=mirror_vector(right.accelerometer_m_s2),
    )
    for frame in ("anatomical", "walking"):
        expected = predict(right, NETWORK, frame=frame).angles_rad
        result = predict(left, NETWORK, frame=frame, side="left").angles_rad
        np.testing.assert_allclose(result, expected, atol=1e-9)


def test_walking_frame_does_not_mind_how_the_sensor_sits(walk):
    recording = sensor_on(walk)
    aligned = predict(recording, INTEGRATING, frame="walking", start_pose="known")
    anyhow = predict(turned(recording, MOUNTING), INTEGRATING, start_pose="known")
    np.testing.assert_allclose(anyhow.angles_rad, aligned.angles_rad, atol=1e-9)
    assert any(note.startswith("frame walking") for note in anyhow.notes)
    # the walk's principal axis is a few degrees off the segment's, by design of this motion
    assert np.corrcoef(anyhow.angles_rad[:, 0], walk.angles_rad[:, 0])[0, 1] > 0.99


def test_sensor_frame_is_made_upright(walk):
    tilted = turned(sensor_on(walk), Rotation.from_euler("y", 30.0, degrees=True))
    result = predict(tilted, INTEGRATING, frame="sensor", start_pose="known")
    np.testing.assert_allclose(result.angles_rad, walk.angles_rad, atol=np.radians(0.05))


def test_irregular_times_and_another_rate(motion):
    fast = motion("stand_walk_stand", 400.0)
    keep = np.cumsum(np.random.default_rng(0).integers(3, 6, size=3900))
    recording = sensor_on(fast)
    some = ImuRecording(
        "imu",
        recording.time_s[keep] + 12.0,
        recording.gyroscope_rad_s[keep],
        recording.accelerometer_m_s2[keep],
    )
    result = predict(some, INTEGRATING, frame="anatomical", start_pose="known")
    np.testing.assert_array_equal(result.time_s, some.time_s)
    np.testing.assert_allclose(result.angles_rad, fast.angles_rad[keep], atol=np.radians(0.1))


def test_missing_samples_are_missing_and_short_gaps_do_no_harm(walk):
    recording = sensor_on(walk)
    gyroscope = recording.gyroscope_rad_s.copy()
    missing = np.arange(600, 3400, 100)
    gyroscope[missing] = np.nan
    gyroscope[1500:1503, 1] = np.nan
    holed = replace(recording, gyroscope_rad_s=gyroscope)
    result = predict(holed, INTEGRATING, frame="anatomical", start_pose="known")
    there = np.isfinite(gyroscope).all(axis=1)
    assert np.isnan(result.angles_rad[~there]).all()
    np.testing.assert_allclose(
        result.angles_rad[there], walk.angles_rad[there], atol=np.radians(0.05)
    )


def test_bias_is_found_in_the_still_part(walk):
    recording = sensor_on(walk)
    biased = replace(recording, gyroscope_rad_s=recording.gyroscope_rad_s + BIAS_RAD_S)
    clean = predict(recording, NETWORK, frame="anatomical", remove_bias=False)
    for still_s in (None, (0.5, 3.5)):
        found = predict(biased, NETWORK, frame="anatomical", still_s=still_s)
        np.testing.assert_allclose(found.bias_rad_s, BIAS_RAD_S, atol=np.radians(0.05))
        np.testing.assert_allclose(found.angles_rad, clean.angles_rad, atol=np.radians(0.5))
    left_in = predict(biased, NETWORK, frame="anatomical", remove_bias=False)
    assert left_in.bias_rad_s is None
    assert np.abs(left_in.angles_rad - clean.angles_rad).max() > np.radians(1.0)


def test_a_walk_without_rest_keeps_its_bias_with_a_note(motion, tmp_path):
    walking = sensor_on(motion("walking"))
    cut = walking.gyroscope_rad_s[300:]
    save(checkpoint(5.0), tmp_path / "net.pt")
    with pytest.warns(UserWarning, match="static bias not removed, no 1 s at rest"):
        angles_from_gyroscope(cut, 100.0, checkpoint=tmp_path / "net.pt")


def test_a_gyroscope_mounted_otherwise_is_reported_first(walk, tmp_path):
    save(checkpoint(5.0), tmp_path / "net.pt")
    rate = MOUNTING.apply(sensor_on(walk).gyroscope_rad_s)
    with pytest.raises(RecordingError, match=r"^recording: the leg swings about .*frame=anatom"):
        angles_from_gyroscope(rate, 100.0, checkpoint=tmp_path / "net.pt")
    rate[2000:2200] = np.nan
    with pytest.warns(UserWarning, match=r"^the leg swings about .*; 1 gap longer"):
        angles_from_gyroscope(rate, 100.0, frame="anatomical", checkpoint=tmp_path / "net.pt")


def test_one_line_of_python(walk, tmp_path):
    save(checkpoint(5.0), tmp_path / "net.pt")
    recording = sensor_on(walk)
    angles = angles_from_gyroscope(
        recording.gyroscope_rad_s.tolist(), 100.0, checkpoint=tmp_path / "net.pt"
    )
    np.testing.assert_array_equal(
        angles, predict(recording, NETWORK, frame="anatomical").angles_rad
    )
    anyhow = turned(recording, MOUNTING)
    angles = angles_from_gyroscope(
        anyhow.gyroscope_rad_s,
        100.0,
        accelerometer_m_s2=anyhow.accelerometer_m_s2,
        checkpoint=tmp_path / "net.pt",
    )
    np.testing.assert_array_equal(angles, predict(anyhow, NETWORK, frame="walking").angles_rad)


def test_standard_deviation_comes_along(walk):
    method = checkpoint(5.0, std=(0.01, 0.02, 0.03)).method()
    recording = sensor_on(walk)
    gyroscope = recording.gyroscope_rad_s.copy()
    gyroscope[100] = np.nan
    std = predict(replace(recording, gyroscope_rad_s=gyroscope), method, frame="anatomical").std_rad
    assert np.isnan(std[100]).all()
    np.testing.assert_allclose(std[101], [0.01, 0.02, 0.03])
    assert predict(recording, NETWORK, frame="anatomical").std_rad is None


def test_standard_deviation_stays_between_that_of_the_start_up_and_the_rest(walk):
    """At a different rate and irregular times it is interpolated across the step between them."""
    finished = checkpoint(5.0, std=(0.01, 0.02, np.nan))
    method = replace(finished, start_std_rad=(0.03, 0.01, np.nan)).method()
    recording = sensor_on(walk)
    n = len(recording.time_s)
    time_s = 0.0131 * np.arange(n) + 0.001 * np.sin(np.arange(n))
    std = predict(replace(recording, time_s=time_s), method, frame="anatomical").std_rad
    assert np.isnan(std[:, 2]).all()
    assert set(np.round(std[[0, -1], 0], 12)) == {0.03, 0.01}
    assert std[:, 0].min() == 0.01
    assert std[:, 0].max() == 0.03
    assert std[:, 1].max() == 0.02


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"frame": "body"},
            "predict: frame is 'body', expected one of auto, anatomical, walking, sensor",
        ),
        ({"side": "middle"}, "predict: side is 'middle', expected one of right, left"),
        ({"start_pose": "lying"}, "predict: start_pose is 'lying', expected one of known, unknown"),
        ({"still_s": (90.0, 95.0)}, "file.csv: no gyroscope sample in still_s 90-95 s"),
    ],
)
def test_wrong_choices_are_one_line(walk, options, message):
    with pytest.raises(UserError, match=f"^{message}"):
        predict(sensor_on(walk), NETWORK, where="file.csv", **options)


def test_missing_data_are_reported(walk, motion):
    recording = sensor_on(walk)
    no_force = replace(recording, accelerometer_m_s2=np.full((recording.n_samples, 3), np.nan))
    with pytest.raises(RecordingError, match=r"^w: frame=walking needs an accelerometer"):
        predict(no_force, NETWORK, frame="walking", where="w")
    nothing = replace(recording, gyroscope_rad_s=np.full((recording.n_samples, 3), np.nan))
    with pytest.raises(RecordingError, match=r"^w: no two gyroscope samples"):
        predict(nothing, NETWORK, where="w")
    walking = sensor_on(motion("walking"))
    moving = ImuRecording(
        "imu",
        walking.time_s[:3000],
        walking.gyroscope_rad_s[300:3300],
        walking.accelerometer_m_s2[300:3300],
    )
    with pytest.raises(RecordingError, match=r"^w: start_pose=known with frame=walking needs"):
        predict(moving, NETWORK, start_pose="known", where="w")
    off = sensor_on(motion("tilted"))
    with pytest.raises(RecordingError, match=r"^w: the gyroscope is zero throughout"):
        predict(off, NETWORK, where="w")
    noise = np.random.default_rng(0).normal(0.0, 0.01, (off.n_samples, 3))
    with pytest.raises(RecordingError, match=r"^w: .*hardly turns .*is it walking"):
        predict(replace(off, gyroscope_rad_s=noise), NETWORK, where="w")
    # sway that is faster forward than backward, as a swing
    phase = 2.0 * np.pi * off.time_s
    noise[:, 1] = 0.02 * (np.cos(phase) + 0.5 * np.cos(2.0 * phase))
    with pytest.raises(RecordingError, match=r"^w: .*hardly turns .*is it walking"):
        predict(replace(off, gyroscope_rad_s=noise), NETWORK, where="w")
    with pytest.raises(UserError, match=r"^sampling_rate_hz is 0.0, expected a positive number"):
        angles_from_gyroscope(recording.gyroscope_rad_s, 0)


@pytest.mark.skipif(
    not (resources.files("narx.inference") / "shipped.pt").is_file(), reason="no network ships yet"
)
def test_the_shipped_network_follows_a_walk(walk):
    angles = angles_from_gyroscope(sensor_on(walk).gyroscope_rad_s, 100.0)
    error = (angles - walk.angles_rad)[500:, 0]
    assert np.sqrt(np.mean(error**2)) < np.radians(5.0)


def test_a_known_bias_is_taken_off(walk):
    walk = sensor_on(walk)
    biased = replace(walk, gyroscope_rad_s=walk.gyroscope_rad_s + BIAS_RAD_S)
    options = {"frame": "anatomical", "start_pose": "unknown"}
    known = predict(biased, INTEGRATING, bias_rad_s=BIAS_RAD_S, **options)
    np.testing.assert_array_equal(known.bias_rad_s, BIAS_RAD_S)
    without = predict(walk, INTEGRATING, remove_bias=False, **options)
    np.testing.assert_allclose(known.angles_rad, without.angles_rad, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bias_rad_s": [0.1, 0.2]}, "bias_rad_s is .*, expected three numbers in rad/s"),
        ({"bias_rad_s": [5.0, 0.0, 0.0]}, r"together below 0\.175"),
        ({"bias_rad_s": "much"}, "bias_rad_s is 'much'"),
        ({"bias_rad_s": BIAS_RAD_S, "still_s": (0.0, 1.0)}, "bias_rad_s and still_s exclude"),
        ({"bias_rad_s": BIAS_RAD_S, "remove_bias": False}, "remove_bias=false exclude each other"),
    ],
)
def test_a_bias_that_is_none_is_refused(walk, options, message):
    with pytest.raises(UserError, match=message):
        predict(sensor_on(walk), INTEGRATING, **options)


def test_a_tracker_receives_bias_uncertainty_and_accelerometer(walk):
    walk = sensor_on(walk)
    model = Narx(100.0, Normalisation(3.0, 0.5))
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, 0.05)))
    moving = replace(
        walk, gyroscope_rad_s=walk.gyroscope_rad_s + 0.2 * np.sin(30.0 * walk.time_s)[:, None]
    )
    plain = Checkpoint(model, tracker=PostureTracker()).method()
    found = predict(moving, plain, frame="anatomical")
    sure = predict(moving, plain, frame="anatomical", bias_rad_s=[0.0, 0.0, 0.0])
    assert found.bias_rad_s is None
    # a second after the start, only the unknown bias can explain the difference
    assert (found.std_rad[300, 2] > sure.std_rad[300, 2]).all()
    aided = Checkpoint(model, tracker=PostureTracker(aided=True)).method()
    assert np.isfinite(predict(walk, aided, frame="anatomical").angles_rad).all()
    lacking = replace(walk, accelerometer_m_s2=np.full_like(walk.accelerometer_m_s2, np.nan))
    with pytest.raises(RecordingError, match="aided=true needs an accelerometer"):
        predict(lacking, aided, frame="anatomical")


@pytest.mark.parametrize(
    ("frame", "aided", "refused"),
    [("walking", False, True), ("sensor", False, True), ("anatomical", True, True),
     ("anatomical", False, False)],
)  # fmt: skip
def test_an_accelerometer_in_g_is_refused_where_it_is_needed(walk, frame, aided, refused):
    in_g = sensor_on(walk)
    in_g = replace(in_g, accelerometer_m_s2=in_g.accelerometer_m_s2 / GRAVITY_M_S2)
    method = Checkpoint(checkpoint(5.0).model, tracker=PostureTracker(aided=True)).method()
    method = method if aided else NETWORK
    if not refused:
        assert np.isfinite(predict(in_g, method, frame=frame).angles_rad).all()
        return
    with pytest.raises(RecordingError, match=r"^w: .* median size is 1 m/s\^2.*; g\?$"):
        predict(in_g, method, frame=frame, where="w")


def test_a_gyroscope_that_contradicts_is_only_noted_in_the_sensor_frame(walk):
    """A segment other than the leg may be translated without rotation."""
    right = sensor_on(walk)
    reversed_ = replace(right, gyroscope_rad_s=-right.gyroscope_rad_s)
    notes = predict(reversed_, INTEGRATING, frame="sensor").notes
    assert any("turns the other way" in note for note in notes)
    with pytest.raises(RecordingError, match="turns the other way"):
        predict(reversed_, INTEGRATING, frame="anatomical")
