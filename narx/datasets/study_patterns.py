"""Patterns of file names with fields: `{subject}/{trial}_{segment}.csv`."""

import re
from collections.abc import Collection, Mapping
from pathlib import Path

from narx.datasets.segment_names import SEGMENT_PATTERN, segment_of
from narx.errors import UserError
from narx.recordings.input_file import is_bundle

FIELDS = ("subject", "condition", "trial", "segment")
_FIELD = re.compile(r"\{(\w*)\}|(\*\*/?|\*|\?)")
# what matches more last; two side by side match what the last of them does
_WIDTHS = ("[^/]*?", "[^/]*", ".*")
_FOLDERS = "(?:.*/)?"
_WILDCARDS = {"{any}": _WIDTHS[0], "*": _WIDTHS[1], "**": _WIDTHS[2], "**/": _FOLDERS}
# the time to find that a path does not match grows with the power of their number
_MAX_WILDCARDS = 8


class FilePattern:
    """A pattern of paths below a study's folder.

    Parameters
    ----------
    pattern : str
        Path with slashes. Fields are ``{subject}``, ``{condition}``, ``{trial}``, ``{segment}``;
        ``{any}`` and ``*`` stand for anything but a slash, ``**`` for any folders. A field that
        occurs twice has the same value in both places.
    segments : mapping of str to str
        Segment for each value of ``{segment}`` in a name. If empty, ``{segment}`` is the name of a
        body part with its side, such as ``thigh_right``, ``LShank``, ``r_foot``.
    where : str
        Key of the pattern, for messages.

    Raises
    ------
    UserError
        If a field is unknown, or there are too many wildcards.
    """

    def __init__(self, pattern: str, segments: Mapping[str, str], where: str) -> None:
        self.pattern = pattern
        self._segments = {name.lower(): segment for name, segment in segments.items()}
        self._where = where
        self._expression = re.compile(self._translated(pattern), re.IGNORECASE)

    def _translated(self, pattern: str) -> str:
        parts: list[str] = []
        end, used = 0, set()
        for found in _FIELD.finditer(pattern):
            literal = re.escape(pattern[end : found.start()])
            parts += [literal] if literal else []
            end = found.end()
            field = found[1]
            if found[0] in _WILDCARDS:
                _append_wildcard(parts, _WILDCARDS[found[0]])
            elif found[0] == "?":
                parts.append("[^/]")
            elif field not in FIELDS:
                known = ", ".join(f"{{{name}}}" for name in (*FIELDS, "any"))
                raise UserError(
                    f"{self._where} is '{pattern}': no field {{{field}}}, expected {known}"
                )
            elif field in used:
                parts.append(f"(?P={field})")
            else:
                used.add(field)
                value = self._segment_expression() if field == "segment" else "[^/]+?"
                parts.append(f"(?P<{field}>{value})")
        if sum(part in _WILDCARDS.values() for part in parts) > _MAX_WILDCARDS:
            raise UserError(
                f"{self._where} is '{pattern}', expected at most {_MAX_WILDCARDS} of {{any}}, * "
                "and **"
            )
        return "".join([*parts, re.escape(pattern[end:])])

    def _segment_expression(self) -> str:
        if not self._segments:
            return SEGMENT_PATTERN
        # the longest first, since one name may be the start of another
        names = sorted(self._segments, key=len, reverse=True)
        return "|".join(re.escape(name) for name in names)

    def fields(self, path: str) -> dict[str, str] | None:
        """Match a path.

        Parameters
        ----------
        path : str
            Below the study's folder, with slashes.

        Returns
        -------
        dict of str to str, or None
            Field to value, the segment by its own name; None if the path does not match.
        """
        match = self._expression.fullmatch(path)
        if match is None:
            return None
        found = match.groupdict()
        if "segment" in found:
            name = found["segment"]
            found["segment"] = self._segments.get(name.lower()) or segment_of(name)
        return found


def _append_wildcard(parts: list[str], wildcard: str) -> None:
    """Add the expression of a wildcard, merged with one directly before it."""
    before = parts[-1] if parts else ""
    if before in _WIDTHS and wildcard in _WIDTHS:
        parts[-1] = max(before, wildcard, key=_WIDTHS.index)
    elif before != _FOLDERS or wildcard != _FOLDERS:
        parts.append(wildcard)


def files_below(folder: Path, left_out: Collection[str] = ()) -> list[str]:
    """List the paths that may be recordings.

    Parameters
    ----------
    folder : pathlib.Path
        The study's folder.
    left_out : collection of str
        Paths to exclude.

    Returns
    -------
    list of str
        Files, and folders of a phone app, below it with slashes, sorted; without hidden ones.
    """
    found = []
    for path in sorted(folder.rglob("*")):
        relative = path.relative_to(folder)
        if any(part.startswith(".") for part in relative.parts):
            continue
        if relative.as_posix() not in left_out and (is_bundle(path) or not path.is_dir()):
            found.append(relative.as_posix())
    return found
