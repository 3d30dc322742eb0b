"""Changes of the fuzzer's inputs: a description stays one, a text keeps its lines and words."""

import json
import math
import random
import re
from typing import Any

import atheris

# what readers and settings treat in ways of their own
_WORDS: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 3, 5.0, 50, 1e-3, 1e6, 1e19, 1e30, 1e300, 2**62, math.nan,
    math.inf, [], {}, "", " ", "\n", "\r", "\0", "nan", "inf", "n/a", "1e999", "1_0", "1,5", "٣",
    '"', "'", "sep=;", "#", ";", "\t", ",", "true", "null", "{", "${x}", "!!python/none x",
    "&a [*a]", "time_s", "time_ms", "time_us", "2024-01-01T00:00:00Z", "12:00:00.5 PM", "59:59.9",
    "gyroscope_x_rad_s", "gyroscope_x_deg_s", "accelerometer_x_g", "rad/s", "deg/s", "m/s^2",
    "{axis}", "{unit}", "{any}", "{segment}", "{subject}", "**", "thigh_right", "shank_left",
    "float32", "int64", "int8", "uint64", "bool", "string", "list", "dictionary", "decimal",
    "time", "timestamp", "timestamp_s", "timestamp_utc", "duration", "date32", "binary", "cell",
    "char", "complex128", "text", "S4", "U4", "utf-16", "utf-32", "cp1252", "UTC", "../x",
    "a" * 300, "9" * 400,
)  # fmt: skip


def mutated(data: bytes, max_size: int, seed: int) -> bytes:
    """Change an input, as libFuzzer asks for.

    Parameters
    ----------
    data : bytes
        The input.
    max_size : int
        Of the changed input.
    seed : int
        Decides on the change, together with the state of libFuzzer.

    Returns
    -------
    bytes
        The changed input; the same if a change is not possible.
    """
    rng = random.Random(seed)
    if data.startswith(b"{"):
        try:
            document = json.loads(data)
            for _ in range(rng.choice([1, 1, 2, 4])):
                _change(document, rng)
            changed = json.dumps(document).encode()
        except (ValueError, OverflowError, RecursionError):
            return data
    elif rng.random() < 0.5 and b"\0" not in data:
        changed = _changed_text(data.decode("utf-8", "replace"), rng).encode("utf-8", "replace")
    else:
        changed = atheris.Mutate(data, max_size)
    return changed if len(changed) <= max_size else data


def _places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths to all parts of a description."""
    found = [path] if path else []
    inside = value.items() if isinstance(value, dict) else ()
    for key, part in enumerate(value) if isinstance(value, list) else inside:
        found += _places(part, (*path, key))
    return found


def _part(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def _change(document: dict[str, Any], rng: random.Random) -> None:
    """Remove, double, rename, exchange or alter a part of a description."""
    places = _places(document)
    if not places:
        document["rows"] = 1
        return
    path = rng.choice(places)
    within, key = _part(document, path[:-1]), path[-1]
    part, kind = within[key], rng.random()
    if kind < 0.1:
        del within[key]
    elif kind < 0.2 and isinstance(within, list):
        within.insert(rng.randrange(len(within) + 1), json.loads(json.dumps(part)))
    elif kind < 0.2:
        within[str(rng.choice(_WORDS))[:40]] = within.pop(key) if rng.random() < 0.5 else part
    elif kind < 0.3:
        within[key] = json.loads(json.dumps(_part(document, rng.choice(places))))
    elif kind < 0.45:
        within[key] = rng.choice(_WORDS)
    elif isinstance(part, bool) or part is None or isinstance(part, dict | list):
        within[key] = [part] if rng.random() < 0.3 else rng.choice(_WORDS)
    elif isinstance(part, str):
        within[key] = _changed_text(part, rng)
    elif abs(part) < 1e9:
        scaled = part * 10.0 ** rng.randint(-12, 12)
        within[key] = rng.choice([-part, part + 1, part - 1, scaled, str(part), 0, int(part)])
    else:
        within[key] = rng.choice([0, 1])


def _changed_text(text: str, rng: random.Random) -> str:
    """Change the letters, words or lines of a text."""
    if rng.random() < 0.4:
        data = text.encode("utf-8", "replace")
        return atheris.Mutate(data, len(data) + 40).decode("utf-8", "replace")
    parts = re.split(rng.choice([r"(\n)", r"([,;\t])", r"([^\w.+-])"]), text)
    at, word = rng.randrange(len(parts)), str(rng.choice(_WORDS))
    parts[at] = rng.choice(["", parts[at] * 2, rng.choice(parts), word, parts[at] + word])
    return "".join(parts)
