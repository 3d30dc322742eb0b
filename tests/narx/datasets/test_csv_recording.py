"""A user's CSV file: units by column name, lossless round trip, errors that name the damage."""

import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from omegaconf import OmegaConf

from narx.datasets.csv_recording import read_recording, write_recording
from narx.datasets.device_layouts import layout_from
from narx.errors import RecordingError
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording

_values = arrays(
    float, (7, 3), elements=st.floats(-1e4, 1e4, allow_subnormal=False) | st.just(np.nan)
)


@settings(max_examples=30, deadline=None)
@given(gyroscope=_values, accelerometer=_values, seed=st.integers(0, 1000))
def test_written_then_read_is_equal(tmp_path_factory, gyroscope, accelerometer, seed):
    time = np.cumsum(np.random.default_rng(seed).uniform(1e-3, 0.1, 7)) + 1e5
    recording = ImuRecording("shank_left", time, gyroscope, accelerometer)
    path = tmp_path_factory.mktemp("csv") / "recording.csv"
    write_recording(path, recording)
    read = read_recording(path, "shank_left")
    assert read.segment == "shank_left"
    for name in ("time_s", "gyroscope_rad_s", "accelerometer_m_s2"):
        assert np.array_equal(getattr(read, name), getattr(recording, name), equal_nan=True)


def _table(gyroscope="rad_s", accelerometer="m_s2", n=5):
    columns = {"time_s": np.arange(n) / 100.0, "comment": ["x"] * n}
    for k, axis in enumerate("xyz"):
        columns[f"gyroscope_{axis}_{gyroscope}"] = np.arange(n) + k
        if accelerometer:
            columns[f"accelerometer_{axis}_{accelerometer}"] = np.full(n, float(k == 2))
    return pd.DataFrame(columns)


@pytest.fixture
def written(tmp_path):
    def write(table):
        path = tmp_path / "recording.csv"
        path.write_text(table if isinstance(table, str) else table.to_csv(index=False))
        return path

    return write


def test_an_accelerometer_that_the_description_leaves_out_is_noted(written):
    given = {
        "time": {"names": "time_s", "unit": "s"},
        "gyroscope": {"names": [f"gyroscope_{axis}_rad_s" for axis in "xyz"], "unit": "rad/s"},
    }
    recording = read_recording(written(_table()), layout=layout_from(given, "columns"))
    assert np.isnan(recording.accelerometer_m_s2).all()
    assert "no accelerometer in columns, accelerometer_x_m_s2" in recording.notes[-1]


def test_units_are_converted(written):
    recording = read_recording(written(_table("deg_s", "g")))
    assert recording.gyroscope_rad_s[1] == pytest.approx(np.radians([1, 2, 3]))
    assert recording.accelerometer_m_s2[0] == pytest.approx([0, 0, GRAVITY_M_S2])


def test_the_accelerometer_is_optional_and_order_does_not_matter(written):
    table = _table(accelerometer=None)
    recording = read_recording(written(table[table.columns[::-1]]))
    assert (recording.gyroscope_rad_s[2] == [2, 3, 4]).all()
    assert np.isnan(recording.accelerometer_m_s2).all()


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (_table().drop(columns="time_s"), "no column 'time_s'"),
        (_table().drop(columns="gyroscope_y_rad_s"), "no column 'gyroscope_y_rad_s' beside"),
        (_table("furlong"), "no column 'gyroscope_x_rad_s' or 'gyroscope_x_deg_s'"),
        (_table(accelerometer="ft_s2"), "no column 'accelerometer_x_m_s2' or 'accelerometer_x_g'"),
        (_table().assign(time_s=[0, 0.1, 0.1, 0.2, 0.3]), "does not increase at data row 3"),
        (_table().assign(gyroscope_x_rad_s="fast"), "line 2, column gyroscope_x_rad_s"),
        (_table().to_csv(index=False)[:-9], "cut off"),
        (_table(accelerometer=None).to_csv(index=False)[:-2], "cut off"),
        ("", "empty"),
    ],
)
def test_damage_ends_in_one_line(written, table, message):
    with pytest.raises(RecordingError, match=message) as caught:
        read_recording(written(table))
    assert "\n" not in str(caught.value)
    assert "recording.csv" in str(caught.value)


@pytest.mark.parametrize(
    "table",
    [
        _table().drop(columns="time_s"),
        _table().drop(columns="gyroscope_y_rad_s"),
        _table().rename(columns=lambda name: name[:1] + name[10:]),
    ],
)
def test_a_missing_column_shows_how_other_names_are_given(written, table, tmp_path):
    with pytest.raises(RecordingError, match="; other names are given as columns=") as caught:
        read_recording(written(table))
    given = OmegaConf.create(str(caught.value).rsplit("columns=", 1)[1])
    layout = layout_from(OmegaConf.to_container(given), "columns")
    own = _table("deg_s", "g").drop(columns="comment")
    path = tmp_path / "own.csv"
    own.set_axis(["T", "WX", "AX", "WY", "AY", "WZ", "AZ"], axis=1).to_csv(path, index=False)
    recording = read_recording(path, layout=layout)
    assert recording.gyroscope_rad_s[1] == pytest.approx(np.radians([1, 2, 3]))
    assert recording.accelerometer_m_s2[0] == pytest.approx([0, 0, GRAVITY_M_S2])


@pytest.mark.parametrize(
    ("gyroscope", "accelerometer"),
    [
        ("Gyro {} (deg/s)", "Acc {} (g)"),
        ("Gyroscope {} [deg/s]", "Accelerometer {} [g]"),
        ("Gyr{}(deg/s)", "Accel{}(g)"),
        ("gyro {}_dps", "acc {}_g"),
    ],
)
def test_names_with_blanks_and_units_in_brackets(written, gyroscope, accelerometer):
    columns = {"Timestamp (ms)": 10 * np.arange(5)}
    for k, axis in enumerate("XYZ"):
        columns[gyroscope.format(axis)] = np.arange(5) + k
        columns[accelerometer.format(axis)] = np.full(5, float(k == 2))
    recording = read_recording(written(pd.DataFrame(columns)))
    assert recording.time_s[1] == pytest.approx(0.01)
    assert recording.gyroscope_rad_s[1] == pytest.approx(np.radians([1, 2, 3]))
    assert recording.accelerometer_m_s2[0] == pytest.approx([0, 0, GRAVITY_M_S2])


def test_a_parquet_file_of_billions_of_equal_values_is_refused(tmp_path):
    path = tmp_path / "bomb.parquet"
    piece = pyarrow.array(np.zeros(1_000_000))
    schema = pyarrow.schema([("time_s", pyarrow.float64())])
    with pyarrow.parquet.ParquetWriter(path, schema) as writer:
        for _ in range(200):
            writer.write_table(pyarrow.table([piece], schema=schema))
    assert path.stat().st_size < 2**20
    with pytest.raises(RecordingError, match="more than the limit of 4096 MiB"):
        read_recording(path)


@pytest.mark.parametrize("kind", ["index", "dates as index", "elapsed"])
def test_parquet_with_times_as_pandas_writes_them(tmp_path, device_walk, kind):
    walk = device_walk(50.0, 6.0)
    table = pd.DataFrame(walk.columns())
    if kind == "dates as index":
        table["time"] = pd.Timestamp("2024-05-01T10:00") + pd.to_timedelta(table.time_s, unit="s")
    elif kind == "elapsed":
        table["time"] = pd.to_timedelta(table.time_s, unit="s")
    if kind != "index":
        table = table.drop(columns="time_s")
    if kind != "elapsed":
        table = table.set_index("time_s" if kind == "index" else "time")
    table.to_parquet(tmp_path / "walk.parquet")
    recording = read_recording(tmp_path / "walk.parquet")
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-6)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s)


def test_a_matlab_struct_of_arrays(tmp_path, device_walk):
    walk = device_walk(50.0, 6.0)
    scipy.io.savemat(tmp_path / "walk.mat", {"imu": walk.columns()})
    recording = read_recording(tmp_path / "walk.mat")
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s)
