"""Device files through reader, plausibility checks and shipped network to the true angles."""

import re

import numpy as np
import pytest

from narx.datasets.csv_recording import read_recording
from narx.errors import RecordingError, UserError
from narx.inference.predict import angles_from_gyroscope, predict
from narx.inference.pretrained import load_or_pretrained

# what the plain file gives, sagittal, frontal, transverse, and a little more
PLAIN_SD_DEG = np.array([0.5, 0.6, 0.5])


@pytest.fixture(scope="module")
def method():
    return load_or_pretrained(None).method(False)


@pytest.fixture
def run(tmp_path, text_of, method):
    """Write columns, read them, predict."""

    def from_columns(columns, **options):
        path = tmp_path / "walk.csv"
        path.write_text(text_of(columns))
        return predict(read_recording(path), method, where="walk.csv", **options)

    return from_columns


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 30.0)


def _dropped(walk):
    """A tenth of the packets, of one or two samples, is lost."""
    keep = np.random.default_rng(3).random(len(walk.time_s)) > 0.1
    return {name: values[keep] for name, values in walk.columns().items()}


def _lost_packets(walk):
    """A tenth of the packets of five is lost: gaps of 0.12 s and more."""
    keep = np.repeat(np.random.default_rng(3).random(300) > 0.1, 5)
    return {name: values[keep] for name, values in walk.columns().items()}


def _held_for_most_of_a_stride(walk):
    columns = walk.columns()
    for name in [name for name in columns if name.startswith("gyro")]:
        columns[name] = columns[name].copy()
        columns[name][850:900] = columns[name][850]
    return columns


def _jittered(walk):
    stamps = walk.time_s + np.random.default_rng(4).normal(0.0, 0.006, len(walk.time_s))
    return walk.columns() | {"time_s": stamps}


def _packets(walk):
    last = np.minimum(np.arange(1500) // 6 * 6 + 5, 1499)
    return walk.columns() | {"time_s": walk.time_s[last] + 0.002 + 0.0003 * (np.arange(1500) % 6)}


def _slower_accelerometer(walk):
    columns = walk.columns(accelerometer=True)
    for name in columns:
        if name.startswith("acc"):
            columns[name] = np.where(np.arange(1500) % 4, np.nan, columns[name])
    return columns


@pytest.mark.parametrize(
    ("columns", "note"),
    [
        (lambda w: w.columns(), None),
        (_dropped, r"gaps of up to 0.\d+ s interpolated"),
        (_lost_packets, r"gaps of up to 0.\d+ s filled from the rhythm of the recording"),
        (_held_for_most_of_a_stride, "repeat their predecessor bit by bit"),
        (_jittered, "jitter of the stamps .* a regular clock of 50"),
        (_packets, "stamps at arrival of packets of 6 samples: a regular clock of 50"),
        (_slower_accelerometer, "on one time axis"),
    ],
)
def test_correctable_files_give_the_angles_of_the_plain_file(run, walk, columns, note):
    result = run(columns(walk), frame="anatomical")
    error = walk.error_sd_deg(result.time_s, result.angles_rad)
    assert (error < PLAIN_SD_DEG).all(), error
    assert note is None or any(re.search(note, one) for one in result.notes)


@pytest.mark.parametrize("fault", ["held", "zeros", "spike"])
def test_a_sensor_fault_is_as_good_as_a_missing_sample(run, walk, fault):
    rows = {"held": slice(850, 900), "zeros": slice(850, 853), "spike": slice(900, 901)}[fault]
    missing = slice(851, 900) if fault == "held" else rows
    faulty, holed = walk.columns(), walk.columns()
    for name in [name for name in faulty if name.startswith("gyro")]:
        faulty[name], holed[name] = faulty[name].copy(), holed[name].copy()
        faulty[name][rows] = {"held": faulty[name][850], "zeros": 0.0, "spike": 30.0}[fault]
        holed[name][missing] = np.nan
    result = run(faulty, frame="anatomical")
    np.testing.assert_array_equal(result.angles_rad, run(holed, frame="anatomical").angles_rad)
    assert np.isnan(result.angles_rad[missing]).all()
    assert any("taken as missing" in note for note in result.notes)


def test_clipping_is_said(run, walk):
    columns = walk.columns()
    for name in columns:
        if name.startswith("gyro"):
            columns[name] = np.clip(columns[name], -1.74533, 1.74533)
    assert any("of the rows are at the same extreme value" in n for n in run(columns).notes)


@pytest.mark.parametrize(
    ("columns", "options", "message"),
    [
        (lambda w: w.columns() | {"time_s": 1e3 * w.time_s}, {}, "milliseconds"),
        (lambda w: {n: np.degrees(v) if "gyro" in n else v for n, v in w.columns().items()}, {},
         "deg/s in a column of rad/s"),
        (lambda w: {n: v[300:] for n, v in w.columns().items()}, {"still_s": (6.0, 7.0)},
         "still_s 6-7 s is not at rest: the gyroscope varies by"),
        (lambda w: {n: np.where(w.time_s < 3, np.nan, v) if "gyro" in n else v
                    for n, v in w.columns().items()}, {"start_pose": "known"},
         "the gyroscope's first 3.00 s are missing"),
        (lambda w: {n: v[310:] for n, v in w.columns().items()}, {"start_pose": "known"},
         "start_pose=known, but the sensor turns by"),
        (lambda w: {n: -v if "gyroscope_y" in n else v
                    for n, v in w.columns(True).items()}, {}, "turns the other way"),
        (lambda w: {n: -v if "_y_" in n else v
                    for n, v in w.columns(True).items()}, {}, "mirrored frame"),
    ],
)  # fmt: skip
def test_implausible_files_are_refused_in_one_line(run, walk, columns, options, message):
    with pytest.raises(RecordingError, match=f"^(walk.csv|.*/walk.csv): .*{message}") as caught:
        run(columns(walk), frame=options.pop("frame", "anatomical"), **options)
    assert "\n" not in str(caught.value)


def test_a_walk_too_short_for_the_network_is_said(run, walk):
    columns = {name: values[250:290] for name, values in walk.columns().items()}
    assert any("all angles are the start-up's" in note for note in run(columns).notes)
    assert not any("start-up's" in note for note in run(walk.columns()).notes)
    columns = {name: values[250:400] for name, values in walk.columns().items()}
    assert any(note.startswith("too short: the network takes over") for note in run(columns).notes)
    assert not any("too short" in note for note in run(walk.columns()).notes)


def test_a_lost_stretch_is_said(run, walk):
    keep = (walk.time_s < 16) | (walk.time_s > 18)
    notes = run({name: values[keep] for name, values in walk.columns().items()}).notes
    assert any(re.search(r"^1 gap longer than 1.1 s .* the network pauses there", n) for n in notes)


def test_python_warns_about_the_processing(walk):
    rate = walk.gyroscope_rad_s.copy()
    rate[900] = 30.0
    with pytest.warns(UserWarning, match="1 sample with a spike .* missing, the first at 18 s"):
        angles_from_gyroscope(rate, 50.0)
    with pytest.raises(UserError, match="50 Hz, if it is the interval in s"):
        angles_from_gyroscope(rate, 0.02)
