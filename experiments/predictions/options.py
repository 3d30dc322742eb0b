"""Validation of the options of `narx-predict`."""

from pathlib import Path
from typing import Literal

from omegaconf import DictConfig, ListConfig, OmegaConf

from narx.datasets.device_layouts import layout_from, read_layout
from narx.datasets.layout import Layout
from narx.errors import UserError
from narx.settings.wording import shown


def interval_s(value: object, key: str) -> tuple[float, float] | None:
    """Check an interval.

    Parameters
    ----------
    value : object
        Value from the configuration.
    key : str
        Name of the key, for messages.

    Returns
    -------
    tuple of (float, float) or None
        Start and end, s.

    Raises
    ------
    UserError
        If the value is not two increasing numbers.
    """
    if value is None:
        return None
    numbers = list(value) if isinstance(value, ListConfig) else []
    if (
        len(numbers) != 2
        or not all(isinstance(number, int | float) for number in numbers)
        or not numbers[0] < numbers[1]
    ):
        raise UserError(f"{key} is {value}, expected [begin, end] in s")
    return float(numbers[0]), float(numbers[1])


def layout_of(cfg: DictConfig) -> Layout | None:
    """Read the column names of the input from the options.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With ``columns`` (a description) and ``device`` (a YAML file with one); at most one.

    Returns
    -------
    Layout or None
        None if neither is given; the columns are then recognised by their names.

    Raises
    ------
    UserError
        If both are given, or the description is invalid.
    """
    if cfg.columns is not None and cfg.device is not None:
        raise UserError("columns and device are both given, expected only one of them")
    if cfg.device is not None:
        return read_layout(Path(str(cfg.device)))
    if cfg.columns is None:
        return None
    content = OmegaConf.to_container(cfg.columns) if isinstance(cfg.columns, DictConfig) else None
    if not isinstance(content, dict):
        raise UserError(f"columns is {cfg.columns}, expected time, gyroscope and accelerometer")
    return layout_from({str(key): value for key, value in content.items()}, "columns")


# one file of one sensor, many of them, sensors of a session, a long session in parts, or data=
Kind = Literal["file", "files", "session", "parts", "trials"]
# options that are not for every kind: what has them, the kinds, and the values that ask for nothing
_OPTIONS: tuple[tuple[str, set[Kind], dict[str, object]], ...] = (
    ("one sensor", {"file", "files"},
     {"frame": "auto", "side": "right", "remove_bias": True, "bias_rad_s": None,
      "still_file": None}),
    ("several sensors", {"session", "parts", "trials"}, {"calibration": "auto"}),
    ("several sensors, predicted at once,", {"session", "trials"}, {"walking_s": None}),
    ("recordings predicted at once", {"file", "files", "session", "trials"}, {"still_s": None}),
    ("many recordings", {"files", "parts", "trials"},
     {"format": "csv", "jobs": None, "scheduler": None}),
    ("a session in parts", {"parts"}, {"partition_s": 900.0}),
    ("data=", {"trials"}, {"select": {"subject": None, "condition": None, "trial": None}}),
    ("input=", {"file", "files", "session", "parts"}, {"columns": None, "device": None}),
)  # fmt: skip


def refuse_unused(cfg: DictConfig, kind: Kind) -> None:
    """Refuse an option that would have no effect on these recordings.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    kind : {"file", "files", "session", "parts", "trials"}
        What is predicted.

    Raises
    ------
    UserError
        If an option is given that this kind does not have.
    """
    for what, kinds, options in _OPTIONS:
        for key, default in options.items():
            if kind not in kinds and cfg[key] != default:
                raise UserError(f"{key} is {shown(cfg[key])}, which is an option of {what} only")
