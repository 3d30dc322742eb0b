"""Arrays in a MATLAB file, with an error that names the file and the field."""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from narx.datasets.mat_structure import check_structure
from narx.errors import RecordingError
from narx.recordings.input_file import LARGEST_NUMBER, regular_file
from narx.types import FloatArray


def read_mat(path: Path) -> dict[str, Any]:
    """Read the variables of a MATLAB 5 file.

    Parameters
    ----------
    path : pathlib.Path
        File to read.

    Returns
    -------
    dict of str to object
        Arrays, and structs as objects with attributes; MATLAB's own entries are left out.

    Raises
    ------
    RecordingError
        If the file is missing, cut off, not a MATLAB file, or needs too much memory.
    """
    regular_file(path)
    try:
        check_structure(path)
        variables = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except RecordingError:
        raise
    except Exception as error:  # the exception depends on the damage
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordingError(
            f"{path}: not a whole MATLAB file ({reason}); cut off? expected a version 5 .mat file"
        ) from None
    return {name: value for name, value in variables.items() if not name.startswith("__")}


def numeric_field(path: Path, variables: dict[str, Any], name: str) -> FloatArray:
    """Look up a numeric field, ``struct.field.field`` with dots.

    Parameters
    ----------
    path : pathlib.Path
        File that the variables are from, for the message.
    variables : dict
        As from `read_mat`.
    name : str
        Field to look up.

    Returns
    -------
    ndarray
        The field as float.

    Raises
    ------
    RecordingError
        If the field is missing, not numeric, or has a number beyond 1e100 or infinity.
    """
    first, *rest = name.split(".")
    if first not in variables:
        raise RecordingError(f"{path}: no variable '{first}'; found {', '.join(variables)}")
    value = variables[first]
    for part in rest:
        if not hasattr(value, part):
            found = ", ".join(getattr(value, "_fieldnames", [])) or type(value).__name__
            raise RecordingError(f"{path}: no field '{name}' (at '{part}'); found {found}")
        value = getattr(value, part)
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise RecordingError(f"{path}: field '{name}' is not numeric") from None
    # in a damaged file, a NaN may be a signalling one, which warns in every sum
    numbers = np.where(np.isnan(numbers), np.nan, numbers)
    largest = np.max(np.abs(numbers), where=~np.isnan(numbers), initial=0.0)
    if largest > LARGEST_NUMBER:
        raise RecordingError(
            f"{path}: field '{name}' has a number of size {largest:.0e} (damaged?), expected at "
            f"most {LARGEST_NUMBER:.0e}"
        )
    return numbers
