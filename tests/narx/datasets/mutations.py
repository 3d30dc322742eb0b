"""Damaged recordings for the readers; the same seed gives the same file."""

import io
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet
import scipy.io

_RATES_HZ = (20.0, 50.0, 100.0, 128.0)
_HOSTILE_CELLS = (
    "1e30", "1e308", "-1e999", "inf", "nan", "", "0x10", "1_0", "1,5", "NULL", "∞", "1e-400", "٣",
    "'", '"', '""', "=1+1", "2024-01-01T00:00:00Z", "true", "\x00", " ", "9" * 400,
)  # fmt: skip
_NAMES = (
    "time_s", "time_ms", "time_us", "time_ns", "gyroscope_x_rad_s", "gyroscope_x_deg_s",
    "accelerometer_x_g", "", "time_s ", "läufer", "gyroscope_w_rad_s", "a" * 500,
)  # fmt: skip


def _walk(generator: np.random.Generator) -> pd.DataFrame:
    rate_hz = generator.choice(_RATES_HZ)
    time = np.arange(0.0, generator.uniform(0.1, 25.0), 1.0 / rate_hz)
    swing = np.outer(np.sin(2 * np.pi * 0.9 * time), [0.2, 2.0, 0.4])
    columns = {"time_s": time}
    for k, axis in enumerate("xyz"):
        columns[f"gyroscope_{axis}_rad_s"] = swing[:, k] + generator.normal(0, 0.01, len(time))
    if generator.random() < 0.6:
        for axis, mean in zip("xyz", (0.5, 0.1, 9.7), strict=True):
            columns[f"accelerometer_{axis}_m_s2"] = mean + generator.normal(0, 0.3, len(time))
    return pd.DataFrame(columns)


def _numbers(table: pd.DataFrame, generator: np.random.Generator) -> pd.DataFrame:
    """Damage to the numbers: clocks, units, impossible values."""
    table = table.copy()
    n = len(table)
    column = generator.integers(table.shape[1])
    row = generator.integers(n)
    kind = generator.integers(12)
    if kind == 0:
        table.iloc[row:, 0] += 10.0 ** generator.integers(0, 12)
    elif kind == 1:
        table.iloc[:, 0] *= 10.0 ** generator.integers(-12, 12)
    elif kind == 2:
        table.iloc[row, column] = 10.0 ** generator.integers(-300, 300)
    elif kind == 3:
        table = table.sample(frac=1.0, random_state=int(generator.integers(2**31)))
    elif kind == 4:
        table.iloc[:, 0] = table.iloc[::-1, 0].to_numpy()
    elif kind == 5:
        table.iloc[:, column] = np.nan
    elif kind == 6:
        table.iloc[:, 1:] *= 10.0 ** generator.integers(-30, 30)
    elif kind == 7:
        table.iloc[:, column] = float(generator.choice([0.0, 1.0, np.inf, -1e308]))
    elif kind == 8:
        table = table.iloc[: generator.integers(0, 4)]
    elif kind == 9:
        table.iloc[row : row + 50] = table.iloc[row].to_numpy()
    elif kind == 10:
        table = table.rename(columns={table.columns[column]: str(generator.choice(_NAMES))})
    else:
        table.iloc[generator.random(n) < 0.3, 1:] = np.nan
    return table


def _text(data: bytes, generator: np.random.Generator) -> bytes:
    """Damage to a text: cells, lines, separators, encodings."""
    lines = data.decode("utf-8").splitlines()
    kind = generator.integers(9)
    row = int(generator.integers(len(lines)))
    if kind == 0:
        separator = max(",\t: ", key=lines[row].count)
        cells = lines[row].split(separator)
        cells[generator.integers(len(cells))] = str(generator.choice(_HOSTILE_CELLS))
        lines[row] = separator.join(cells)
    elif kind == 1:
        del lines[row]
    elif kind == 2:
        lines.insert(row, lines[generator.integers(len(lines))])
    elif kind == 3:
        lines = [line.replace(",", str(generator.choice([";", "\t", "|", " ", ",,"])))
                 for line in lines]  # fmt: skip
    elif kind == 4:
        lines[row] = lines[row][: generator.integers(len(lines[row]) + 1)]
    elif kind == 5:
        lines = [line.replace(".", ",") for line in lines]
    elif kind == 6:
        lines.insert(0, "sep=;")
    elif kind == 7:
        return "\n".join(lines).encode(str(generator.choice(["utf-16", "utf-8-sig", "cp1252"])))
    else:
        lines[row] *= int(generator.integers(2, 50))
    return ("\n".join(lines) + "\n").encode("utf-8")


def _bytes(data: bytes, generator: np.random.Generator) -> bytes:
    """Damage to the bytes of any file."""
    damaged = bytearray(data)
    kind = generator.integers(5)
    if kind == 0:
        return bytes(damaged[: generator.integers(len(damaged) + 1)])
    if kind == 1:
        for _ in range(int(generator.integers(1, 20))):
            damaged[generator.integers(len(damaged))] ^= 1 << generator.integers(8)
        return bytes(damaged)
    at = int(generator.integers(len(damaged)))
    if kind == 2:
        return bytes(damaged[:at]) + generator.bytes(int(generator.integers(1, 64))) + data[at:]
    if kind == 3:
        return data[at:] + data[:at]
    damaged[at : at + 8] = b"\xff" * len(damaged[at : at + 8])
    return bytes(damaged)


def _csv(table: pd.DataFrame) -> bytes:
    return table.to_csv(index=False).encode("utf-8")


def _parquet(table: pd.DataFrame) -> bytes:
    stream = io.BytesIO()
    # pandas does not write duplicate column names
    arrays = [pyarrow.array(table.iloc[:, k].to_numpy()) for k in range(table.shape[1])]
    pyarrow.parquet.write_table(pyarrow.Table.from_arrays(arrays, list(table.columns)), stream)
    return stream.getvalue()


def _mat(table: pd.DataFrame) -> bytes:
    stream = io.BytesIO()
    # MATLAB limits the length of names
    columns = {name[:31]: values.to_numpy() for name, values in table.items() if name.strip()}
    scipy.io.savemat(stream, columns, do_compression=len(table) % 2 == 0)
    return stream.getvalue()


def _zip(table: pd.DataFrame) -> bytes:
    stream = io.BytesIO()
    gyroscope = table.iloc[:, :4].set_axis(["seconds_elapsed", "x", "y", "z"], axis=1)
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Gyroscope.csv", gyroscope.to_csv(index=False))
    return stream.getvalue()


_WRITERS: dict[str, Callable[[pd.DataFrame], bytes]] = {
    ".csv": _csv, ".parquet": _parquet, ".mat": _mat, ".zip": _zip,
}  # fmt: skip


def damaged_file(folder: Path, seed: int) -> Path:
    """Write a recording with one to three kinds of damage.

    Parameters
    ----------
    folder : pathlib.Path
        Where to.
    seed : int
        Decides all of it.

    Returns
    -------
    pathlib.Path
        The file.
    """
    generator = np.random.default_rng([20, seed])
    suffix = str(generator.choice([".csv", ".csv", ".parquet", ".mat", ".zip"]))
    table = _walk(generator)
    if generator.random() < 0.6:
        table = _numbers(table, generator)
    data = _WRITERS[suffix](table)
    if suffix == ".csv" and generator.random() < 0.7:
        data = _text(data, generator)
    if generator.random() < 0.3 and data:
        data = _bytes(data, generator)
    path = folder / f"{seed}{suffix}"
    path.write_bytes(data)
    return path


def damaged_set(intact: Path, folder: Path, seed: int) -> str:
    """Copy a small data set with one or two of its files damaged.

    Parameters
    ----------
    intact : pathlib.Path
        Folder of the data set.
    folder : pathlib.Path
        Folder that is made.
    seed : int
        Decides all of it.

    Returns
    -------
    str
        What was done.
    """
    generator = np.random.default_rng([21, seed])
    shutil.copytree(intact, folder)
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    done = []
    for _ in range(int(generator.integers(1, 3))):
        path = files[generator.integers(len(files))]
        kind = generator.random()
        if not path.is_file():  # damaged before
            continue
        data = path.read_bytes()
        if kind < 0.04:
            path.unlink()
            kind_of_damage = "removed"
        elif kind < 0.08:
            path.unlink()
            path.mkdir()
            kind_of_damage = "a folder"
        elif kind < 0.12:
            other = files[generator.integers(len(files))]
            if other.is_file():
                path.write_bytes(other.read_bytes())
            kind_of_damage = f"content of {other.name}"
        elif not data:
            continue
        elif path.suffix == ".mat" or kind < 0.35:
            path.write_bytes(_bytes(data, generator))
            kind_of_damage = "bytes"
        else:
            try:
                path.write_bytes(_text(data, generator))
            except (UnicodeError, ValueError):  # damaged before
                path.write_bytes(_bytes(data, generator))
            kind_of_damage = "text"
        done.append(f"{path.relative_to(folder)}: {kind_of_damage}")
    return ", ".join(done)
