"""The same numbers from every dialect of CSV that devices and spreadsheets write."""

import gzip
import os
import re

import numpy as np
import pandas as pd
import pytest

from narx.datasets.csv_recording import read_recording
from narx.datasets.text_dialect import read_table
from narx.errors import RecordingError


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 6.0)


def _lines(text):
    return text.splitlines()


def _with_index(text):
    first, *rest = _lines(text)
    return "\n".join([f",{first}", *(f"{k},{line}" for k, line in enumerate(rest))]) + "\n"


def _with_unnamed_index(text):
    first, *rest = _lines(text)
    return "\n".join([first, *(f"{k},{line}" for k, line in enumerate(rest))]) + "\n"


def _after_header(text, line):
    first, *rest = _lines(text)
    return "\n".join([first, line, *rest]) + "\n"


def _quoted(text):
    first, *rest = _lines(text)
    quoted = ",".join(f'"{name}"' for name in first.split(","))
    return "\n".join([quoted, *rest]) + "\n"


def _quoted_cells(text):
    return "\n".join(",".join(f'"{c}"' for c in line.split(",")) for line in _lines(text)) + "\n"


UNITS = "s,rad/s,rad/s,rad/s,m/s^2,m/s^2,m/s^2"
DIALECTS = {
    "byte order mark": lambda plain, text: b"\xef\xbb\xbf" + plain.encode(),
    "utf-16": lambda plain, text: plain.encode("utf-16"),
    "utf-16 without mark": lambda plain, text: plain.encode("utf-16-le"),
    "utf-16, big end first": lambda plain, text: plain.encode("utf-16-be"),
    "utf-32": lambda plain, text: plain.encode("utf-32"),
    "sep= as an escape": lambda plain, text: b"sep=\\t\n" + text("\t").encode(),
    "whole lines quoted": lambda plain, text: (
        "\n".join(f'"{line}"' for line in _lines(plain)).encode() + b"\n"
    ),
    "end of a DOS file": lambda plain, text: plain.encode() + b"\x1a",
    "sign of typography": lambda plain, text: plain.replace("-", "\u2212").encode(),
    "metadata as wide as the table": lambda plain, text: (
        b"Rate,50,,,,,\nSerial,7,,,,,\n,,,,,,\n" + plain.encode()
    ),
    "short names": lambda plain, text: (
        plain.replace("gyroscope", "gyr").replace("accelerometer", "acc").encode()
    ),
    "units in brackets without a blank": lambda plain, text: (
        plain.replace("_rad_s", "(rad/s)").replace("_m_s2", "[m/s^2]").encode()
    ),
    "carriage returns": lambda plain, text: plain.replace("\n", "\r\n").encode(),
    "old Mac": lambda plain, text: plain.replace("\n", "\r").encode(),
    "quoted header": lambda plain, text: _quoted(plain).encode(),
    "quoted cells": lambda plain, text: _quoted_cells(plain).encode(),
    "quoted decimal commas": lambda plain, text: _quoted_cells(plain).replace(".", ",").encode(),
    "semicolon, decimal comma": lambda plain, text: text(";", ",").encode(),
    "tab": lambda plain, text: text("\t").encode(),
    "tab, decimal comma": lambda plain, text: text("\t", ",").encode(),
    "blanks": lambda plain, text: text("  ").encode(),
    "bar": lambda plain, text: text("|").encode(),
    "sep=": lambda plain, text: b"sep=;\r\n" + text(";").encode(),
    "quoted sep=": lambda plain, text: b'"sep=\t"\n' + text("\t").encode(),
    "units row": lambda plain, text: _after_header(plain, UNITS).encode(),
    "units row in brackets": lambda plain, text: _after_header(
        plain, ",".join(f"[{unit}]" for unit in UNITS.split(","))
    ).encode(),
    "index column": lambda plain, text: _with_index(plain).encode(),
    "index without a name": lambda plain, text: _with_unnamed_index(plain).encode(),
    "separator at the end": lambda plain, text: plain.replace("\n", ",\n").encode(),
    "separator at the end of numbers": lambda plain, text: (
        plain.replace("\n", ",\n").replace(",\n", "\n", 1).encode()
    ),
    "comment lines": lambda plain, text: b"# device 7\n# 50 Hz\n" + plain.encode(),
    "metadata": lambda plain, text: b"Device: 7\nRate,50\n\n" + plain.encode(),
    "header behind a comment sign": lambda plain, text: b"# " + plain.encode(),
    "blanks after commas": lambda plain, text: plain.replace(",", ", ").encode(),
    "blank lines": lambda plain, text: plain.replace("\n", "\n\n").encode(),
    "units in brackets in the names": lambda plain, text: (
        plain.replace("_rad_s", " (rad/s)").replace("_m_s2", " [m/s^2]").encode()
    ),
    "units only in their row": lambda plain, text: _after_header(
        plain.replace("_rad_s", "").replace("_m_s2", "").replace("time_s", "time"), UNITS
    ).encode(),
    "header again in the middle": lambda plain, text: (
        "\n".join([*_lines(plain)[:100], *_lines(plain)[:1], *_lines(plain)[100:]]).encode() + b"\n"
    ),
    "means below": lambda plain, text: plain.encode() + b"\nSamples: 300\nMean,1,2,3,4,5,6\nEnd\n",
    "units row, German": lambda plain, text: _after_header(
        text(";", ",")
        .replace("gyroscope", "Drehrate")
        .replace("accelerometer", "Beschleunigung")
        .replace("_rad_s", "")
        .replace("_m_s2", "")
        .replace("time_s", "Zeit"),
        UNITS.replace(",", ";"),
    ).encode("utf-8-sig"),
    "units in brackets, Spanish": lambda plain, text: (
        text("\t", ",")
        .replace("gyroscope_", "Velocidad angular ")
        .replace("time_s", "Tiempo [s]")
        .replace("accelerometer_", "Aceleración ")
        .replace("_rad_s", " [rad/s]")
        .replace("_m_s2", " [m/s²]")
        .encode("cp1252")
    ),
    "units in brackets, Polish": lambda plain, text: (
        text(";", ",")
        .replace("gyroscope_", "Prędkość kątowa ")
        .replace("time_s", "Czas [s]")
        .replace("accelerometer_", "Przyspieszenie ")
        .replace("_rad_s", " [rad/s]")
        .replace("_m_s2", " [m/s²]")
        .encode()
    ),
    "comment below": lambda plain, text: plain.encode() + b"# end\n",
    "remarks below": lambda plain, text: plain.encode() + b"End of recording\nSamples: 20\n",
    "upper case": lambda plain, text: plain.replace("gyro", "GYRO").encode(),
    "Latin-1 comment": lambda plain, text: "# Läufer in °/s\n".encode("latin-1") + plain.encode(),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_gives_the_same_numbers(tmp_path, walk, text_of, dialect):
    columns = walk.columns(accelerometer=True)
    path = tmp_path / "walk.csv"
    path.write_bytes(
        DIALECTS[dialect](text_of(columns), lambda *options: text_of(columns, *options))
    )
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-5)
    np.testing.assert_allclose(recording.gyroscope_rad_s, walk.gyroscope_rad_s, atol=1e-5)
    np.testing.assert_allclose(recording.accelerometer_m_s2, walk.accelerometer_m_s2, atol=1e-5)


@pytest.mark.parametrize(
    "word",
    [
        "",
        "NA",
        "N/A",
        "NaN",
        "nan",
        "null",
        "NULL",
        "-",
        "#N/A",
        "?",
        "N.A.",
        "---",
        "no data",
        "\u2013",
    ],
)
def test_words_for_a_missing_value(tmp_path, walk, text_of, word):
    path = tmp_path / "walk.csv"
    text = _lines(text_of(walk.columns()))
    text[101] = ",".join([text[101].split(",")[0], *[word] * 3])
    path.write_text("\n".join(text) + "\n")
    gyroscope = read_recording(path).gyroscope_rad_s
    assert np.isnan(gyroscope[100]).all()
    assert np.isfinite(np.delete(gyroscope, 100, axis=0)).all()


@pytest.mark.parametrize(("separator", "decimal", "cell"), [
    (";", ".", "1,234.5"), (";", ",", "1.234,5"), (";", ",", "1 234,5"), (";", ".", "1'234.5"),
])  # fmt: skip
def test_groups_of_thousands(tmp_path, separator, decimal, cell):
    path = tmp_path / "t.csv"
    small = "0.5".replace(".", decimal)
    path.write_text(f"a{separator}b\n{small}{separator}{small}\n{cell}{separator}{small}\n")
    np.testing.assert_array_equal(read_table(path).numbers(0), [0.5, 1234.5])


def test_units_row_gives_the_unit_and_may_not_contradict(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    text = _after_header(text_of(walk.columns()), "s,deg/s,deg/s,deg/s")
    path.write_text(text)
    with pytest.raises(RecordingError, match="gyroscope_x_rad_s has units deg/s and rad_s"):
        read_recording(path)


def test_deviations_from_plain_csv_are_noted(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    path.write_text(text_of(walk.columns(), ";", ","))
    assert read_recording(path).notes == (
        "read as text: fields separated by semicolons, decimal commas",
    )
    path.write_text(text_of(walk.columns()))
    assert read_recording(path).notes == ()


def _cut_inside(text):
    return text[: len(text) // 2].rsplit(",", 1)[0] + "\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda text: text(",", ",").encode(), "are both fields and decimals separated by ','"),
        (lambda text: _cut_inside(text()).encode(), r"line \d+ has [123] values, expected 4"),
        (lambda text: text().replace("time_s", "t").encode(), "no column 'time_s'; found t, gyro"),
        (lambda text: text().replace("0.02000", "0.0_2", 1).encode(), "line 3, column time_s"),
        (lambda text: text().replace("0.02000", "inf", 1).encode(), "found 'inf'"),
        (lambda text: text().replace("0.02000", "1e999", 1).encode(), "found '1e999'"),
        (lambda text: text(header=False).encode(), "no header line with 4 names"),
        (lambda text: text().encode() + b"\0\xff\xfe", "cannot be read as text"),
        (lambda text: b"time_s,gyroscope_x_rad_s\n", "no data lines|no column"),
        (lambda text: text().replace("gyroscope_y", "gyroscope_x").encode(), "occurs 2 times"),
    ],
)
def test_damage_is_one_line_that_names_the_file(tmp_path, walk, text_of, content, message):
    path = tmp_path / "walk.csv"
    path.write_bytes(content(lambda *a, **k: text_of(walk.columns(), *a, **k)))
    with pytest.raises(RecordingError, match=message) as caught:
        read_recording(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_paths_that_are_not_files_are_refused_immediately(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "large").write_bytes(b"x" * 2**17)
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", "0.1")
    for name, message in {
        tmp_path / "pipe": "is a pipe, expected a file",
        tmp_path / "loop": "cannot be opened",
        tmp_path: "is a folder, expected a file",
        "/dev/zero": "is a device, expected a file",
        tmp_path / "none": "no such file",
        tmp_path / "large": "more than the limit of 0.1 MiB; set the environment variable",
        "a\0b": "cannot be opened",
        "x" * 5000: "cannot be opened",
    }.items():
        with pytest.raises(RecordingError, match=message):
            read_recording(name)


def test_calendar_times(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    stamps = np.datetime64("2026-05-01T23:59:58") + (walk.time_s * 1e6).astype("timedelta64[us]")
    columns = walk.columns() | {"time_s": [f"{stamp}Z" for stamp in stamps]}
    path.write_text(text_of(columns))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-6)
    assert re.match("times count from 2026-05-01T23:59:58", recording.notes[0])
    path.write_text(text_of(columns).replace(":59.000000Z", ":99Z", 1))
    with pytest.raises(RecordingError, match="expected a date and time"):
        read_recording(path)


@pytest.mark.parametrize("form", ["%H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p"])
def test_times_of_day_pass_midnight(tmp_path, walk, text_of, form):
    path = tmp_path / "walk.csv"
    begin = pd.Timestamp("2026-05-01T23:59:58")
    stamps = begin + pd.to_timedelta(walk.time_s, unit="s").round("us")
    path.write_text(text_of(walk.columns() | {"time_s": stamps.strftime(form)}))
    np.testing.assert_allclose(read_recording(path).time_s, walk.time_s, atol=1e-6)
    # the date changes although the time of day goes on
    later = stamps + pd.to_timedelta(np.where(walk.time_s > 3.0, 86_400.0, 0.0), unit="s")
    if form != "%H:%M:%S.%f":
        path.write_text(text_of(walk.columns() | {"time_s": later.strftime(form)}))
        with pytest.raises(RecordingError, match="expected a date and time"):
            read_recording(path)


def test_minutes_and_seconds_of_the_hour(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    of_hour = [divmod(3598.0 + time, 60.0) for time in walk.time_s]
    stamps = [f"{int(minutes) % 60:02d}:{seconds:06.3f}" for minutes, seconds in of_hour]
    path.write_text(text_of(walk.columns() | {"time_s": stamps}))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-6)
    assert "time begins again after 3600 s, continued from there" in recording.notes


@pytest.mark.parametrize(
    ("factor", "unit"), [(1, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns"), (1 / 86400, "days")]
)
def test_times_without_a_unit_are_read_by_their_rate(tmp_path, walk, text_of, factor, unit):
    path = tmp_path / "walk.csv"
    columns = walk.columns()
    columns["time_s"] = walk.time_s * factor
    path.write_text(text_of(columns, digits=12).replace("time_s", "timestamp"))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time_s, walk.time_s, atol=1e-5)
    assert recording.notes[0] == f"column timestamp has no unit: taken as {unit}, 50 Hz"


def test_times_without_a_unit_that_have_no_likely_one_are_refused(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    path.write_text(
        text_of(walk.columns() | {"time_s": walk.time_s / 3600.0}).replace("time_s", "time")
    )
    with pytest.raises(RecordingError, match="column time has numbers without a unit, which are"):
        read_recording(path)


@pytest.mark.parametrize(
    "unit",
    ["deg/sec", "degrees per second", "deg·s⁻¹", "deg s^-1", "° / s", "Deg/Second", "[deg.s-1]"],
)
def test_spellings_of_a_unit(tmp_path, walk, text_of, unit):
    columns = walk.columns()
    bare = dict(zip(["time_s", *(f"gyroscope_{a}" for a in "xyz")], columns.values(), strict=True))
    path = tmp_path / "walk.csv"
    path.write_text(_after_header(text_of(bare), f"seconds,{unit},{unit},{unit}"), "utf-8")
    found = read_recording(path).gyroscope_rad_s
    np.testing.assert_allclose(found, np.radians(walk.gyroscope_rad_s), atol=1e-5)


def test_an_unknown_unit_in_the_units_row_is_named(tmp_path, walk, text_of):
    path = tmp_path / "walk.csv"
    path.write_text(_after_header(text_of(walk.columns()), "s,furlong/s,rad/s,rad/s"))
    with pytest.raises(RecordingError, match="has unit 'furlong/s', expected one of rad_s"):
        read_recording(path)


@pytest.mark.parametrize(("factor", "agrees"), [(180.0 / np.pi, True), (0.0, False)])
def test_a_quantity_in_two_units_must_agree(tmp_path, walk, text_of, factor, agrees):
    columns = walk.columns()
    for axis in "xyz":
        columns[f"gyroscope_{axis}_deg_s"] = factor * columns[f"gyroscope_{axis}_rad_s"]
    path = tmp_path / "walk.csv"
    path.write_text(text_of(columns))
    if agrees:
        found = read_recording(path).gyroscope_rad_s
        np.testing.assert_allclose(found, walk.gyroscope_rad_s, atol=1e-5)
        return
    with pytest.raises(RecordingError, match="gyroscope_x_rad_s and gyroscope_x_deg_s disagree"):
        read_recording(path)


@pytest.mark.parametrize(("factor", "agrees"), [(1e3, True), (500.0, False)])
def test_times_in_two_units_must_agree(tmp_path, walk, text_of, factor, agrees):
    path = tmp_path / "walk.csv"
    path.write_text(text_of(walk.columns() | {"time_ms": factor * walk.time_s}))
    if agrees:
        np.testing.assert_allclose(read_recording(path).time_s, walk.time_s, atol=1e-5)
        return
    with pytest.raises(RecordingError, match="columns time_s and time_ms last"):
        read_recording(path)


def test_a_name_in_other_letters_is_the_same_column(tmp_path, walk, text_of):
    columns = walk.columns()
    columns["GYROSCOPE_X_RAD_S"] = columns["gyroscope_x_rad_s"]
    path = tmp_path / "walk.csv"
    path.write_text(text_of(columns))
    with pytest.raises(RecordingError, match="occurs 2 times"):
        read_recording(path)


def test_compressed_text(tmp_path, walk, text_of, monkeypatch):
    path = tmp_path / "walk.csv.gz"
    packed = gzip.compress(text_of(walk.columns()).encode())
    path.write_bytes(packed)
    np.testing.assert_allclose(read_recording(path).time_s, walk.time_s, atol=1e-5)
    path.write_bytes(packed[:-20])
    with pytest.raises(RecordingError, match=r"walk\.csv\.gz: not a whole gzip file"):
        read_recording(path)
    path.write_bytes(gzip.compress(bytes(3 * 2**20)))
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", "2")
    with pytest.raises(RecordingError, match="MiB"):
        read_recording(path)


@pytest.mark.parametrize("separator", [",", ";"])
def test_a_text_needs_more_memory_than_its_size(tmp_path, walk, text_of, monkeypatch, separator):
    """Plain text is read by pyarrow, all other by the general reader."""
    path = tmp_path / "walk.csv"
    path.write_text(text_of(walk.columns(), separator))
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", str(1.5 * path.stat().st_size / 2**20))
    with pytest.raises(RecordingError, match=r"walk\.csv: needs .* MiB of memory"):
        read_recording(path)


def test_groups_of_thousands_in_points_beside_decimal_commas(tmp_path):
    path = tmp_path / "walk.csv"
    path.write_text("time_us;gyroscope_x_rad_s\n1.234.567;0,1234\n1.254.567;-0,25\n20.000;1,5\n")
    table = read_table(path)
    np.testing.assert_array_equal(table.numbers(0), [1234567.0, 1254567.0, 20000.0])
    np.testing.assert_array_equal(table.numbers(1), [0.1234, -0.25, 1.5])


def test_metadata_above_the_header_are_comments(tmp_path):
    path = tmp_path / "walk.csv"
    path.write_text("Serial Number: T1\ntime_s,gyroscope_x_rad_s\n0.0,1.0\n0.1,2.0\n")
    assert "Serial Number: T1" in read_table(path).comments
