"""Validation of the options of `narx-predict`."""

from pathlib import Path

from omegaconf import DictConfig, ListConfig, OmegaConf

from narx.datasets.device_layouts import layout_from, read_layout
from narx.datasets.layout import Layout
from narx.errors import UserError


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
