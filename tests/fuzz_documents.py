"""Files built from a small description in JSON, so that a change keeps them well formed.

A fuzzer that changes bytes hardly ever gets beyond the checksum of an archive or the footer of a
Parquet file. It changes these descriptions instead, and every reader sees whole files with wrong
content. A column is described by a few numbers::

    {"name": "gyroscope_y_rad_s", "amplitude": 2.0, "period": 55, "values": [0.01, -0.01],
     "put": {"7": null}, "type": "float32"}

that is a sine over the rows, plus values that repeat, plus ``start`` and ``step``; single cells are
put in place of these.
"""

import io
import json
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet
import scipy.io

MOST_ROWS = 1500
_PARQUET_TYPES = {
    "list": pyarrow.list_(pyarrow.float64()),
    "dictionary": pyarrow.dictionary(pyarrow.int32(), pyarrow.string()),
    "decimal": pyarrow.decimal128(30, 6),
    "timestamp": pyarrow.timestamp("ns"),
    "timestamp_s": pyarrow.timestamp("s"),
    "timestamp_utc": pyarrow.timestamp("us", "UTC"),
    "duration": pyarrow.duration("ns"),
    "time": pyarrow.time64("us"),
}


def document_in(data: bytes) -> dict[str, Any] | None:
    """Read a description.

    Parameters
    ----------
    data : bytes
        An input of the fuzzer.

    Returns
    -------
    dict or None
        None if the input is the file itself.
    """
    if not data.startswith(b"{"):
        return None
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def cells(column: Mapping[str, Any], rows: int) -> list[Any]:
    """Cells of a column.

    Parameters
    ----------
    column : mapping
        Its description.
    rows : int
        Number of cells.

    Returns
    -------
    list
        Floats; texts, truth values and None where the description has them.
    """
    given = column.get("values") or [0.0]
    put = {int(row): value for row, value in (column.get("put") or {}).items()}
    start, step = column.get("start", 0.0), column.get("step", 0.0)
    amplitude, period = column.get("amplitude", 0.0), column.get("period", 50.0)
    found: list[Any] = []
    for k in range(rows):
        value = put.get(k, given[k % len(given)])
        if k not in put and isinstance(value, int | float) and not isinstance(value, bool):
            swing = amplitude * np.sin(2 * np.pi * k / period) if amplitude else 0.0
            value = float(value + start + step * k + swing)
        found.append(value)
    return found


def columns_of(document: Mapping[str, Any]) -> list[tuple[str, str, list[Any]]]:
    """Name, type and cells of every column of a table.

    Parameters
    ----------
    document : mapping
        With ``rows`` and ``columns``.

    Returns
    -------
    list of tuple of (str, str, list)
        In order; a column may have its own ``rows``.
    """
    found = []
    for one in document["columns"]:
        rows = min(MOST_ROWS, max(0, int(one.get("rows", document["rows"]))))
        found.append((str(one["name"]), str(one.get("type", "float64")), cells(one, rows)))
    return found


def text(document: Mapping[str, Any]) -> bytes:
    """Table as text, in the dialect that is described.

    Parameters
    ----------
    document : mapping
        A table with, if wanted, ``separator``, ``decimal``, ``above`` and ``below`` (lines),
        ``units``, ``ending`` and ``encoding``.

    Returns
    -------
    bytes
        The file.
    """
    table = columns_of(document)
    separator, decimal = document.get("separator", ","), document.get("decimal", ".")

    def written(value: Any) -> str:
        shown = "" if value is None else value if isinstance(value, str) else f"{value:.7g}"
        return shown.replace(".", decimal) if isinstance(value, float) else shown

    lines = [*document.get("above", []), separator.join(name for name, _, _ in table)]
    if document.get("units"):
        lines.append(separator.join(document["units"]))
    rows = zip(*(values for _, _, values in table), strict=False)
    lines += [separator.join(map(written, row)) for row in rows]
    ending = document.get("ending", "\n")
    whole = ending.join([*lines, *document.get("below", [])]) + ending
    return whole.encode(document.get("encoding", "utf-8"), errors="replace")


def parquet(document: Mapping[str, Any]) -> bytes:
    """Table as a Parquet file.

    Parameters
    ----------
    document : mapping
        A table; types are those of Arrow.

    Returns
    -------
    bytes
        The file.
    """
    arrays, names = [], []
    for name, kind, values in columns_of(document):
        wanted = _PARQUET_TYPES.get(kind) or pyarrow.type_for_alias(kind)
        if kind == "list":
            values = [[value] for value in values]
        elif not pyarrow.types.is_floating(wanted):
            values = [int(v) if isinstance(v, float) and abs(v) < 1e18 else v for v in values]
        if kind in ("string", "dictionary", "decimal"):
            values = [None if v is None else str(v) for v in values]
        arrays.append(pyarrow.array(values, pyarrow.string() if kind == "decimal" else wanted))
        arrays[-1] = arrays[-1].cast(wanted)
        names.append(name)
    stream = io.BytesIO()
    whole = pyarrow.Table.from_arrays(arrays, names)
    pyarrow.parquet.write_table(whole, stream, row_group_size=document.get("group") or 10_000)
    return stream.getvalue()


def mat(document: Mapping[str, Any]) -> bytes:
    """Arrays as a MATLAB file.

    Parameters
    ----------
    document : mapping
        A table; a column has a ``width``, and ``struct`` names a struct around all, with dots.

    Returns
    -------
    bytes
        The file.
    """
    variables: dict[str, Any] = {}
    for one in document["columns"]:
        ((name, kind, values),) = columns_of({**document, "columns": [one]})
        width = max(1, int(one.get("width", 1)))
        if kind == "cell":
            variables[name] = np.array([*values, None], dtype=object)[:-1]
        elif kind == "char":
            variables[name] = "".join(map(str, values))
        else:
            array = np.asarray(values, dtype=kind)
            whole = array[: len(array) // width * width]
            variables[name] = whole.reshape(-1, width) if width > 1 else array
    for name in reversed(str(document.get("struct") or "").split(".")):
        variables = {name: variables} if name else variables
    stream = io.BytesIO()
    scipy.io.savemat(
        stream,
        variables,
        format=str(document.get("format", "5")),
        do_compression=bool(document.get("compressed")),
        long_field_names=document.get("format", "5") == "5",
        oned_as="row" if document.get("row") else "column",
    )
    return stream.getvalue()


def hdf5(document: Mapping[str, Any]) -> bytes:
    """Data sets and attributes as an HDF5 file.

    Parameters
    ----------
    document : mapping
        A table whose names are paths; a column has a ``width``. ``attributes`` are by path.

    Returns
    -------
    bytes
        The file.
    """
    import h5py  # an optional dependency

    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        for one in document["columns"]:
            ((name, kind, values),) = columns_of({**document, "columns": [one]})
            width = max(1, int(one.get("width", 1)))
            array = np.asarray(values, dtype=object if kind == "text" else kind)
            array = array[: len(array) // width * width].reshape(-1, width)
            as_is = array[:, 0] if width == 1 else array
            if kind == "text":
                as_is = np.array([str(v) for v in as_is.ravel()], dtype=h5py.string_dtype())
            file[name] = as_is
        for path, values in (document.get("attributes") or {}).items():
            group = file.require_group(path)
            for key, value in values.items():
                bytes_or_text = document.get("as_bytes", True)
                if bytes_or_text and isinstance(value, str):
                    value = value.encode()
                elif bytes_or_text and isinstance(value, list):
                    value = [one.encode() if isinstance(one, str) else one for one in value]
                group.attrs[key] = value
    return stream.getvalue()


def archive(document: Mapping[str, Any]) -> bytes:
    """Texts in a zip file.

    Parameters
    ----------
    document : mapping
        ``members``: name to text, or to a table; ``method``: of compression.

    Returns
    -------
    bytes
        The file.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", int(document.get("method", zipfile.ZIP_DEFLATED))) as whole:
        for name, content in document["members"].items():
            whole.writestr(name, content_of(content))
    return stream.getvalue()


def content_of(content: Any) -> bytes:
    """Content of a file that is described as a text, a table or plain data.

    Parameters
    ----------
    content : object
        A text is the file itself; a table is written as text, and anything else as JSON, which is
        YAML as well.

    Returns
    -------
    bytes
        The file.
    """
    if isinstance(content, str):
        return content.encode(errors="replace")
    if isinstance(content, dict) and "columns" in content and "rows" in content:
        return text(content)
    return json.dumps(content).encode()
