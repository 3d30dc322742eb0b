"""The NeuRA walk: stand, walk, turn, walk, stand."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets import neura_sample
from narx.datasets.neura_sample import NeuraSample
from narx.errors import RecordingError
from narx.inference.start_up import StartUp
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import orientation_from_angles

pytestmark = pytest.mark.recordings


@pytest.fixture(scope="module")
def root(data_root):
    if not (data_root / "neura_sample").is_dir():
        pytest.skip("no neura_sample")
    return data_root / "neura_sample"


@pytest.fixture(scope="module")
def trial(root):
    return next(iter(NeuraSample(root=root)))


def test_parts_of_the_recording(trial):
    assert trial.name == "neura_sample/S02/Walk/1"
    assert set(trial.imus) == {"thigh_right", "thigh_left", "shank_right", "shank_left"}
    (_, first), (second, end) = trial.still_s
    assert first == pytest.approx(11.0, abs=0.3)
    assert end - second == pytest.approx(3.0, abs=0.6)
    begin, turn = trial.walking_s
    assert begin == pytest.approx(11.2, abs=0.4)
    assert 14.2 < turn < 14.9
    assert trial.clock_offset_s["shank_right"] == pytest.approx(0.020, abs=0.005)


def test_reference_moves_like_a_walk_and_the_gyroscopes_with_it(trial):
    calibrated = calibrate(trial)
    walk = (trial.time_s > trial.walking_s[0]) & (trial.time_s < trial.walking_s[1])
    for segment, one in calibrated.items():
        angle = one.reference_angles_rad
        assert np.degrees(np.abs(angle[:900, :2])).max() < 1.0
        assert np.isnan(angle[:, 2]).all()
        slope = np.gradient(angle[:, 0], 0.01)
        rate = one.signals.axis_rates_rad_s[:, 0]
        agreement = np.corrcoef(slope[walk], rate[walk])[0, 1]
        assert agreement > (0.95 if segment.startswith("shank") else 0.85), segment
    for side in ("right", "left"):
        knee = np.degrees(
            grood_suntay(*(calibrated[f"{s}_{side}"].reference_wxyz for s in ("thigh", "shank")))
        )
        assert 50 < np.nanpercentile(knee[:, 0], 99) < 75  # knees flex by 60 degrees in swing
        assert -8 < np.nanpercentile(knee[:, 0], 1) < 2
        assert np.abs(knee[-50:].mean(axis=0)).max() < 3.0  # and stand again at the end


def test_heading_misalignment_is_a_few_degrees(trial):
    # with sensors calibrated from the walk alone; reducing the knee's abduction turns the right
    # shank's heading away from that of the markers (docs/recordings.md)
    for one in calibrate(trial, remove_heading_misalignment=True).values():
        note = next(n for n in one.notes if "about the vertical" in n)
        assert abs(float(note.split()[0])) < 15.0


def test_the_knee_takes_cross_talk_out_of_its_abduction(trial):
    """With orientations integrated from the gyroscopes, over the first walk, against Vicon."""
    walk = (trial.time_s > trial.walking_s[0]) & (trial.time_s < trial.walking_s[1])
    start_up = StartUp(duration_s=1000.0)

    def spread_deg(calibrated, side):
        names = [f"{kind}_{side}" for kind in ("thigh", "shank")]
        reference = grood_suntay(*(calibrated[name].reference_wxyz for name in names))
        estimate = grood_suntay(
            *(
                orientation_from_angles(
                    start_up.run(
                        calibrated[name].signals.axis_rates_rad_s,
                        1.0 / trial.sampling_rate_hz,
                        start_up.begin(np.zeros(3)),
                    )
                )
                for name in names
            )
        )
        return np.degrees(np.nanstd((reference - estimate)[walk, 1]))

    by_knee = calibrate(trial)
    # with one segment at a time, the knee cannot be used
    alone = {
        s: calibrate(replace(trial, imus={s: imu}, reference={s: trial.reference[s]}))[s]
        for s, imu in trial.imus.items()
    }
    for side, least in (("right", 1.5), ("left", 0.2)):
        assert spread_deg(by_knee, side) < spread_deg(alone, side) - least


def _swap_lines(path):
    lines = path.read_text().splitlines(keepends=True)
    lines[400], lines[401] = lines[401], lines[400]
    path.write_text("".join(lines))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (_swap_lines, "PacketCounter goes back after row 39"),
        (lambda p: p.write_bytes(p.read_bytes()[:-20]), "cut off"),
        (lambda p: p.write_text(p.read_text().replace("Gyr_Y", "Gyro_Y")), "no column 'Gyr_Y'"),
        (lambda p: p.unlink(), "no such file"),
        (
            lambda p: p.write_text("\n".join(p.read_text().splitlines()[:600]) + "\n"),
            "not as published",
        ),
    ],
)
def test_damage_ends_in_one_clear_line(root, tmp_path, damage, message):
    folder = shutil.copytree(root, tmp_path / "neura", copy_function=shutil.copyfile)
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755)
    damage(folder / "rawimu" / "S02-Trial-Walk-1-000_00B40C35.txt")
    with pytest.raises(RecordingError, match=message) as caught:
        NeuraSample(root=folder).load("S02", "Walk", "1")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("damaged", ["Gyr_X", "Gyr_Y", "Gyr_Z", "yzx", "sides"])
def test_sensors_that_contradict_the_markers_are_refused(root, monkeypatch, damaged):
    """A reversed axis, axes in another order, left and right exchanged."""
    read = neura_sample._read_sensor

    def changed(path):
        if damaged == "sides":
            path = Path(str(path).replace("00B40C35", "00B40BA5"))
        table = read(path)
        if damaged == "yzx":
            table[:, 1:4] = table[:, [2, 3, 1]]
        elif damaged != "sides":
            table[:, 1 + ["Gyr_X", "Gyr_Y", "Gyr_Z"].index(damaged)] *= -1.0
        return table

    monkeypatch.setattr(neura_sample, "_read_sensor", changed)
    with pytest.raises(RecordingError, match=r"_00B40\w+\.txt: .*(axes|agree)"):
        NeuraSample(root=root).load("S02", "Walk", "1")
