"""Exports in the documented layouts of known devices are read as the same samples."""

import zipfile

import numpy as np
import pandas as pd
import pytest
import scipy.io

from narx.datasets.csv_recording import read_recording
from narx.datasets.device_layouts import layout_from, read_layout
from narx.errors import RecordingError, UserError

G = 9.80665


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(60.0, 8.0)


def _table(walk, time, gyroscope, accelerometer, scale=(1.0, 1.0), more=()):
    columns = {time[0]: time[1], **{name: np.zeros(len(walk.time_s)) for name in more}}
    columns |= dict(zip(gyroscope, walk.gyroscope_rad_s.T / scale[0], strict=True))
    columns |= dict(zip(accelerometer, walk.accelerometer_m_s2.T / scale[1], strict=True))
    return columns


def _names(pattern, axes="xyz"):
    return [pattern.format(axis) for axis in axes]


def _movella_dot(walk, text_of):
    time = (4294967296 - 3_000_000 + np.round(walk.time_s * 1e6)) % 4294967296
    columns = _table(walk, ("SampleTimeFine", time), _names("Gyr_{}", "XYZ"),
                     _names("Acc_{}", "XYZ"), (np.pi / 180, 1.0), ["PacketCounter"])  # fmt: skip
    return "sep=,\nDeviceTag:,Xsens DOT\nFirmwareVersion:,2.0.0\n" + text_of(columns)


def _mtw(walk, text_of):
    counter = (65500 + np.arange(len(walk.time_s))) % 65536
    columns = _table(walk, ("PacketCounter", counter), _names("Gyr_{}", "XYZ"),
                     _names("Acc_{}", "XYZ"), more=["SampleTimeFine"])  # fmt: skip
    columns["SampleTimeFine"] = np.full(len(counter), np.nan)
    return "// Start Time: Unknown\n// Update Rate: 60.0Hz\n// Filter: human\n" + text_of(
        columns, "\t"
    )


def _shimmer(walk, text_of):
    columns = _table(walk, ("Shimmer_40AC_Timestamp_Unix_CAL", 1.7e12 + 1e3 * walk.time_s),
                     _names("Shimmer_40AC_Gyro_{}_CAL", "XYZ"),
                     _names("Shimmer_40AC_Accel_WR_{}_CAL", "XYZ"), (np.pi / 180, 1.0))  # fmt: skip
    header, *lines = text_of(columns).splitlines()
    units = "ms,deg/s,deg/s,deg/s,m/(s^2),m/(s^2),m/(s^2)"
    return '"sep=,"\n' + "\n".join(f"{line}," for line in [header, units, *lines]) + "\n"


def _phyphox(walk, text_of):
    columns = _table(walk, ("Time (s)", walk.time_s), _names("Gyroscope {} (rad/s)"),
                     _names("Acceleration {} (m/s^2)"), more=["Absolute (rad/s)"])  # fmt: skip
    return text_of({f'"{name}"': values for name, values in columns.items()}, ";")


def _multi_shimmer_sync(walk, text_of):
    columns = _table(walk, ("Timestamp", 1e3 * walk.time_s), _names("Gyroscope {}", "XYZ"),
                     _names("Low Noise Accelerometer {}", "XYZ"), (np.pi / 180, 1.0),
                     ["Battery"])  # fmt: skip
    header, *lines = text_of(columns, "\t").splitlines()
    rows = [["Shimmer_8C3F"] * 8, header.split("\t"), ["CAL", "RAW", *["CAL"] * 6],
            ["mSecs", "no units", *["deg/sec*"] * 3, *["m/(sec^2)*"] * 3]]  # fmt: skip
    return "\n".join(["\t".join(row) for row in rows] + lines) + "\n"


def _actigraph(walk, text_of):
    begin = pd.Timestamp("2021-05-05T10:00:00")
    stamps = [(begin + pd.Timedelta(seconds=t)).isoformat() for t in walk.time_s.round(6)]
    columns = _table(walk, ("Timestamp", np.zeros(len(walk.time_s))),
                     _names("Gyroscope {}", "XYZ"), _names("Accelerometer {}", "XYZ"),
                     (np.pi / 180, G), ["Temperature"])  # fmt: skip
    header, *lines = text_of(columns).splitlines()
    body = [f"{t},{line.split(',', 1)[1]}" for t, line in zip(stamps, lines, strict=True)]
    above = "--- Data Table File Created By ActiGraph GT9X Link at 60 Hz ---\nSerial Number: T1\n"
    return above + "\n".join([header, *body]) + "\n"


def _androsensor(walk, text_of):
    return text_of(
        _table(walk, ("Time since start in ms", 1e3 * walk.time_s),
               _names("GYROSCOPE {} (rad/s)", "XYZ"),
               _names("ACCELEROMETER {} (m/s\u00b2)", "XYZ")),
        ";",
    )  # fmt: skip


def _physics_toolbox(walk, text_of):
    return text_of(_table(walk, ("time", walk.time_s), _names("w{}"), _names("gF{}"), (1.0, G)))


def _sensorlog(walk, text_of):
    columns = _table(walk, ("motionTimestamp_sinceReboot(s)", walk.time_s),
                     _names("motionRotationRate{}(rad/s)", "XYZ"),
                     _names("accelerometerAcceleration{}(G)", "XYZ"), (1.0, -G))  # fmt: skip
    return text_of(columns)


def _witmotion(walk, text_of):
    columns = _table(walk, ("Time(s)", walk.time_s), _names("w{}(deg/s)"), _names("a{}(g)"),
                     (np.pi / 180, G), ["AngleX(deg)"])  # fmt: skip
    return "StartTime: 2021-05-05 10:00:00\n" + text_of(columns, "\t")


DEVICES = {"movella_dot": _movella_dot, "xsens_mtw": _mtw, "shimmer": _shimmer,
           "phyphox": _phyphox, "actigraph": _actigraph, "androsensor": _androsensor,
           "physics_toolbox": _physics_toolbox, "sensorlog": _sensorlog,
           "witmotion": _witmotion}  # fmt: skip
FORMS = {**DEVICES, "shimmer of MultiShimmerSync": _multi_shimmer_sync}


@pytest.mark.parametrize("form", FORMS)
def test_one_table_with_both_sensors(tmp_path, walk, text_of, form):
    path = tmp_path / "export.csv"
    path.write_text(FORMS[form](walk, text_of))
    recording = read_recording(path)
    assert f"columns as of {form.split()[0]}" in recording.notes
    time = recording.time_s - recording.time_s[0]
    np.testing.assert_allclose(time, walk.time_s, atol=1e-3)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)
    np.testing.assert_allclose(recording.accelerometer_m_s2, walk.accelerometer_m_s2, atol=1e-4)


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("app", ["phyphox", "sensor_logger"])
def test_one_file_a_sensor(tmp_path, device_walk, text_of, app, packed):
    gyroscope = device_walk(60.0, 8.0)
    force = device_walk(time_s=np.arange(400) / 50.0 + 0.004)
    files = {}
    if app == "phyphox":
        for walk, file, name, values in (
            (gyroscope, "Gyroscope.csv", "Gyroscope {} (rad/s)", gyroscope.gyroscope_rad_s),
            (force, "Accelerometer.csv", "Acceleration {} (m/s^2)", force.accelerometer_m_s2),
        ):
            columns = {'"Time (s)"': walk.time_s}
            columns |= {f'"{n}"': v for n, v in zip(_names(name), values.T, strict=True)}
            files[file] = text_of(columns)
    else:
        for walk, name, values in (
            (gyroscope, "Gyroscope.csv", gyroscope.gyroscope_rad_s),
            (force, "TotalAcceleration.csv", force.accelerometer_m_s2),
            (force, "Accelerometer.csv", 0 * force.accelerometer_m_s2),
        ):
            columns = {"time": walk.time_s + 1.7e9, "seconds_elapsed": walk.time_s}
            columns |= dict(zip("zyx", values.T[::-1], strict=True))
            files[name] = text_of(columns)
    path = tmp_path / "export"
    if packed:
        path = tmp_path / "export.zip"
        with zipfile.ZipFile(path, "w") as archive:
            for name, text in files.items():
                archive.writestr(f"2026-05-01/{name}", text)
            archive.writestr("meta/device.csv", "property,value\n")
    else:
        path.mkdir()
        for name, text in files.items():
            (path / name).write_text(text)
    recording = read_recording(path)
    np.testing.assert_allclose(recording.gyroscope_rad_s, gyroscope.gyroscope_rad_s, atol=1e-5)
    there = np.isfinite(recording.accelerometer_m_s2).all(axis=1)
    assert there.mean() > 0.98
    np.testing.assert_allclose(
        recording.accelerometer_m_s2[there], gyroscope.accelerometer_m_s2[there], atol=0.1
    )
    assert f"{app}: gyroscope from Gyroscope.csv" in recording.notes


@pytest.mark.parametrize("dates", [False, True])
def test_parquet(tmp_path, walk, dates):
    table = pd.DataFrame(walk.columns(accelerometer=True)).assign(comment="x")
    if dates:
        table["time_s"] = pd.Timestamp("2026-05-01") + pd.to_timedelta(table["time_s"], unit="s")
    table.to_parquet(tmp_path / "walk.parquet")
    recording = read_recording(tmp_path / "walk.parquet")
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-8)
    np.testing.assert_array_equal(recording.gyroscope_rad_s, walk.gyroscope_rad_s)
    np.testing.assert_array_equal(recording.accelerometer_m_s2, walk.accelerometer_m_s2)


def test_arrays_of_a_matlab_file(tmp_path, walk):
    scipy.io.savemat(tmp_path / "walk.mat", {
        "time_s": walk.time_s, "gyroscope_deg_s": np.degrees(walk.gyroscope_rad_s),
        "accelerometer_g": walk.accelerometer_m_s2.T / G, "subject": "S1", "rate": 60.0,
    })  # fmt: skip
    recording = read_recording(tmp_path / "walk.mat")
    np.testing.assert_allclose(recording.time_s, walk.time_s)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-12)
    np.testing.assert_allclose(recording.accelerometer_m_s2, walk.accelerometer_m_s2, atol=1e-12)


def test_a_description_of_ones_own(tmp_path, walk, text_of):
    columns = _table(walk, ("t", 1e3 * walk.time_s), ["wx", "wy", "wz"], ["ax", "ay", "az"],
                     (np.pi / 180, -G))  # fmt: skip
    (tmp_path / "own.csv").write_text(text_of(columns, digits=7))
    (tmp_path / "device.yaml").write_text(
        "time: {names: t, unit: ms}\n"
        "gyroscope: {names: [wx, wy, wz], unit: deg/s}\n"
        'accelerometer: {names: "a{axis}", unit: g, sign: -1}\n'
    )
    recording = read_recording(tmp_path / "own.csv", layout=read_layout(tmp_path / "device.yaml"))
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-6)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-6)
    np.testing.assert_allclose(recording.accelerometer_m_s2, walk.accelerometer_m_s2, atol=1e-5)


def test_one_column_for_two_axes_is_refused(tmp_path, walk, text_of):
    (tmp_path / "walk.csv").write_text(text_of(walk.columns()))
    twice = {"names": ["gyroscope_x_rad_s", "gyroscope_y_rad_s", "gyroscope_x_rad_s"]}
    layout = layout_from({"time": {"names": "time_s", "unit": "s"},
                          "gyroscope": {**twice, "unit": "rad/s"}}, "columns")  # fmt: skip
    with pytest.raises(RecordingError, match="expected three different ones"):
        read_recording(tmp_path / "walk.csv", layout=layout)


@pytest.mark.parametrize(
    ("description", "message"),
    [
        ({"time": "t"}, "d: no 'gyroscope'"),
        ({"time": "t", "gyroscope": "g{axis}", "magnet": "m"}, "d: 'magnet' is unknown"),
        ({"time": "t", "gyroscope": {"name": "g"}}, "d: gyroscope is .*, expected a pattern"),
        ({"time": "t", "gyroscope": {"names": "g{axis}", "sign": 2}}, "sign is 2, expected 1 or"),
        ({"time": "t", "gyroscope": "{unit}_{axis}_{unit}"}, "expected {unit} at most once"),
        ({"time": "t", "gyroscope": "{any}" * 4 + "{axis}"}, "{any} at most 3 times"),
        ({"time": 3, "gyroscope": "g"}, "d: time is 3, expected a pattern"),
        ({"time": "t", "gyroscope": {"names": 3}}, "names are"),
        (
            {"time": "t", "gyroscope": {"names": "g{axis}", "unit": [1]}},
            "unit is .*expected a name",
        ),
        (
            {"time": {"names": "t", "wraps": "x"}, "gyroscope": "g"},
            "wraps is 'x', expected a whole",
        ),
        ({"time": {"names": "t", "wraps": 0}, "gyroscope": "g"}, "wraps is 0"),
        ({"time": "t", "gyroscope": "g", "files": "a.csv"}, "d.files is 'a.csv', expected"),
        (
            {"time": "t", "gyroscope": "g", "files": {"gyroscope": "a.csv"}},
            "files.gyroscope is 'a.c",
        ),
        ({"time": "t", "gyroscope": "g", "comment": "(a"}, r"comment is '\(a', expected a regular"),
        (
            {"time": {"names": "t", "unit": "packets"}, "gyroscope": "g", "comment": "a"},
            "a group in",
        ),
    ],
)
def test_wrong_descriptions_are_one_line(description, message):
    with pytest.raises(UserError, match=message) as caught:
        layout_from(description, "d")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", ["1.5", "[", "- a", "", "!!python/none x", "[" * 10_000])
def test_a_description_that_is_no_mapping_is_one_line(tmp_path, content):
    (tmp_path / "device.yaml").write_text(content)
    with pytest.raises(UserError, match=r"device\.yaml: (not YAML|holds no mapping|no 'time')"):
        read_layout(tmp_path / "device.yaml")


@pytest.mark.parametrize("name", ["x.parquet", "x.zip", "x.mat"])
@pytest.mark.parametrize("content", [b"", b"PK\x03\x04nothing", b"PAR1" + b"\0" * 40 + b"PAR1"])
def test_damaged_containers_are_one_line(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=f"{name}: ") as caught:
        read_recording(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_a_table_about_a_recording_with_an_endless_field_is_refused(tmp_path):
    samples = "seconds_elapsed,x,y,z\n" + "".join(f"{k / 50},0.1,{k % 7},0\n" for k in range(50))
    with zipfile.ZipFile(tmp_path / "walk.zip", "w") as archive:
        for name in ("Gyroscope.csv", "TotalAcceleration.csv"):
            archive.writestr(name, samples)
        archive.writestr("Metadata.csv", '"' + "a" * 200_000)
    with pytest.raises(RecordingError, match=r"Metadata\.csv: not a table \(field larger"):
        read_recording(tmp_path / "walk.zip")


def test_a_zip_that_unpacks_to_more_than_the_limit_is_refused(tmp_path, monkeypatch):
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Gyroscope.csv", "0" * 2**22)
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", "1")
    with pytest.raises(RecordingError, match="needs 4 MiB of memory, more than the limit of 1 MiB"):
        read_recording(tmp_path / "bomb.zip")
    monkeypatch.undo()
    with pytest.raises(RecordingError, match=r"no (header line|data|column|gyroscope)|a line of"):
        read_recording(tmp_path / "bomb.zip")


@pytest.mark.parametrize(
    ("about", "sign"),
    [
        ("platform,standardisation\nios,false\n", -1),
        ("platform\niOS\n", -1),
        ("platform,standardisation\nios,true\n", 1),
        ("platform,standardisation\nandroid,false\n", 1),
        (None, 1),
    ],
)
def test_sensor_logger_on_ios_has_the_opposite_sign(tmp_path, walk, text_of, about, sign):
    path = tmp_path / "export"
    path.mkdir()
    for name, values in (
        ("Gyroscope.csv", walk.gyroscope_rad_s),
        ("TotalAcceleration.csv", walk.accelerometer_m_s2),
    ):
        columns = {"seconds_elapsed": walk.time_s} | dict(zip("xyz", values.T, strict=True))
        (path / name).write_text(text_of(columns))
    if about is not None:
        (path / "Metadata.csv").write_text(about)
    recording = read_recording(path)
    np.testing.assert_allclose(
        recording.accelerometer_m_s2, sign * walk.accelerometer_m_s2, atol=1e-5
    )
    changed = "accelerometer's sign changed, according to Metadata.csv" in recording.notes
    assert changed == (sign < 0)


@pytest.mark.parametrize(
    ("time", "pattern", "device"),
    [
        ("elapsed (s)", "{}-axis (deg/s)", "metawear"),
        ("sensor timestamp [ns]", "{} [dps]", "polar"),
    ],
)
def test_a_file_of_the_gyroscope_alone(tmp_path, walk, text_of, time, pattern, device):
    scale = 1e9 if "ns" in time else 1.0
    columns = {time: np.round(scale * walk.time_s, 6)}
    rates = np.degrees(walk.gyroscope_rad_s.T)
    columns |= dict(zip(_names(pattern), rates, strict=True))
    path = tmp_path / "export.csv"
    path.write_text(text_of(columns))
    recording = read_recording(path)
    assert f"columns as of {device}" in recording.notes
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)
    assert np.isnan(recording.accelerometer_m_s2).all()


def test_the_rate_of_mt_manager_in_either_comment(tmp_path, walk, text_of):
    """SampleTimeFine counts steps of 0.1 ms there, but microseconds in files of an Xsens DOT."""
    path = tmp_path / "MT_01.txt"
    path.write_text(_mtw(walk, text_of).replace("Update Rate", "Sample rate"))
    assert read_recording(path).sampling_rate_hz == pytest.approx(60.0)


def test_names_of_axes_with_their_units(tmp_path, walk, text_of):
    for number, (time, gyroscope, accelerometer) in enumerate([
        ("time_s", "g{}_deg/s", "a{}_m/s/s"), ("Time (s)", "Gyro-{} (d/s)", "Accel-{} (m/s^2)"),
    ]):  # fmt: skip
        path = tmp_path / f"{number}.csv"
        path.write_text(text_of(_table(walk, (time, walk.time_s), _names(gyroscope),
                                       _names(accelerometer), (np.pi / 180, 1.0))))  # fmt: skip
        recording = read_recording(path)
        np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)
        np.testing.assert_allclose(recording.accelerometer_m_s2, walk.accelerometer_m_s2, atol=1e-5)


def test_a_row_of_units_with_the_form_of_dates(tmp_path, walk):
    begin = pd.Timestamp("2021-05-05T10:00:00")
    lines = ["S_Timestamp_Unix_CAL,S_Gyro_X_CAL,S_Gyro_Y_CAL,S_Gyro_Z_CAL",
             "yyyy/mm/dd hh:mm:ss.000,deg/s,deg/s,deg/s"]  # fmt: skip
    for t, rates in zip(walk.time_s, np.degrees(walk.gyroscope_rad_s), strict=True):
        stamp = (begin + pd.Timedelta(seconds=round(t, 6))).strftime("%Y/%m/%d %H:%M:%S.%f")
        lines.append(",".join([stamp, *(f"{rate:.6f}" for rate in rates)]))
    path = tmp_path / "export.csv"
    path.write_text("\n".join(lines) + "\n")
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-5)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)


@pytest.mark.parametrize("extra", [(), ("__MACOSX/._walk.csv", "a/README.txt"), ("a/other.csv",)])
def test_a_zip_with_one_table(tmp_path, walk, text_of, extra):
    path = tmp_path / "walk.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a/walk.tsv", text_of(walk.columns(), "\t"))
        for name in extra:
            archive.writestr(name, "x")
    if extra == ("a/other.csv",):
        with pytest.raises(RecordingError, match=r"found other\.csv, walk\.tsv"):
            read_recording(path)
        return
    recording = read_recording(path)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)
