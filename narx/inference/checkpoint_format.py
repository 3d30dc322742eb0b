"""Formats of a checkpoint's content; older formats are converted to the current one step by step.

The number is increased when the meaning of a field changes, or when a field is added that affects
how a network runs, so that an older package refuses a newer file instead of running its network
differently.

====== =========================================================================================
format meaning
====== =========================================================================================
1      number within ``model``; without ``washout_s`` no washout, without ``averaging_begin_s`` the
       posture averaged over the end of the start-up, without ``start_std_rad`` no deviation of
       its own there
2      all fields required, no others; ``sha256`` over the content
3      field ``tracker``; without it none
4      field ``known_bias_sd_deg_s`` of the tracker; without it its ``bias_sd_deg_s``
5      fields ``turn_time_s`` and ``turning_time_s`` of the tracker; without them both 0.5 s;
       ``reopened_sd_deg``, ``delay_s``, ``alignment_sd_deg`` and ``corrected_sd_deg``; without
       them none
====== =========================================================================================
"""

from collections.abc import Callable
from typing import Any

from narx.inference.checkpoint_archive import digest

FORMAT = 5
# a tracker's parameters are within these limits, which have no effect
_SMALLEST, _LARGEST = 1e-9, 1e6


def sealed(content: dict[str, Any]) -> dict[str, Any]:
    """Add the format number and the checksum.

    Parameters
    ----------
    content : dict
        A checkpoint's fields.

    Returns
    -------
    dict
        Content of the file.
    """
    numbered = {"format": FORMAT, **content}
    return {**numbered, "sha256": digest(numbered)}


def opened(content: dict[str, Any]) -> dict[str, Any]:
    """Check format number and checksum, and convert older contents to the current format.

    Parameters
    ----------
    content : dict
        Content of a file.

    Returns
    -------
    dict
        A checkpoint's fields.

    Raises
    ------
    ValueError
        If the format is unknown or the checksum wrong.
    """
    content = dict(content)
    number = content.pop("format", None)
    if number is None and isinstance(content.get("model"), dict):
        content["model"] = dict(content["model"])
        number = content["model"].pop("format", None)
    elif number in range(2, FORMAT + 1):
        expected = content.pop("sha256", None)
        if digest({"format": number, **content}) != expected:
            raise ValueError("its content does not match its checksum")
    if number not in (*_TO_NEXT, FORMAT) or isinstance(number, bool):
        raise ValueError(f"its format is {number!r}, expected {FORMAT} or an older one")
    for older in range(number, FORMAT):
        content = _TO_NEXT[older](content)
    return content


def _from_1(content: dict[str, Any]) -> dict[str, Any]:
    start_up = dict(content["start_up"])
    # before this was an option, the posture was averaged over the end of the start-up
    start_up.setdefault("averaging_begin_s", start_up["duration_s"] - start_up["averaging_s"])
    return {"start_std_rad": None, "washout_s": None, **content, "start_up": start_up}


def _from_2(content: dict[str, Any]) -> dict[str, Any]:
    return {**content, "tracker": None}


def _from_3(content: dict[str, Any]) -> dict[str, Any]:
    tracker = content["tracker"]
    if tracker is not None:
        tracker = {"known_bias_sd_deg_s": tracker["bias_sd_deg_s"], **tracker}
    return {**content, "tracker": tracker}


def _from_4(content: dict[str, Any]) -> dict[str, Any]:
    tracker = content["tracker"]
    if tracker is not None:
        before = dict.fromkeys(("turn_time_s", "turning_time_s"), 0.5)
        none = dict.fromkeys(("reopened_sd_deg", "delay_s", "alignment_sd_deg"), _SMALLEST)
        none["corrected_sd_deg"] = _LARGEST
        tracker = {**before, **none, **tracker}
    return {**content, "tracker": tracker}


_TO_NEXT: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {
    1: _from_1,
    2: _from_2,
    3: _from_3,
    4: _from_4,
}
