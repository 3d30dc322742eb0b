"""Names, order and colours of methods, the same in every table and figure."""

from collections.abc import Container, Iterable

_LABELS = {
    "complementary_filter": "CF",
    "complementary_filter_real_time": "CF real time",
    "narx": "NARX",
    "narx_smoothed": "NARX smoothed",
    "narx_axis_by_axis": "NARX axis by axis",
    "pseudo_integrator": "PI",
    "leaky_integrator": "Leaky integrator",
    "gyro_integration": "Gyro integration",
    "strapdown": "Strapdown",
    "giof": "GIOF",
    "giof_two_strides": "GIOF two strides",
    "giof_as_printed": "GIOF as printed",
    "giof_real_time": "GIOF real time",
    "two_point": "2-point",
    "vqf": "VQF",
    "vqf_offline": "VQF offline",
    "madgwick": "Madgwick",
    "mahony": "Mahony",
    "constant": "Constant",
    "zero": "Zero",
}

# NARX red, PI green, CF blue as in Tham et al., Fig. 6; the others can be told apart from these
# and from each other by colour-blind readers as well (Okabe and Ito)
_COLOURS = {
    "narx": "#c8102e",
    "narx_smoothed": "#f28e8e",
    "narx_axis_by_axis": "#7f0000",
    "pseudo_integrator": "#009e73",
    "complementary_filter": "#0060b0",
    "gyro_integration": "#e69f00",
    "giof": "#cc79a7",
    "giof_two_strides": "#8b3a62",
    "giof_as_printed": "#999933",
    "giof_real_time": "#d55e00",
    "complementary_filter_real_time": "#6fa8dc",
    "two_point": "#7b3fa0",
    "vqf": "#7570b3",
    "vqf_offline": "#777777",
    "madgwick": "#56b4e9",
    "mahony": "#8c6d31",
    "leaky_integrator": "#b3a800",
    "strapdown": "#fdae61",
    "constant": "#c0c0c0",
    "zero": "#e0e0e0",
}
# what a figure or a table of strides shows of a benchmark with many rows: the network, its
# counterpart with one parameter and a filter of today with the same ingredients (of each the first
# that there is), and both rivals as printed
_DRAWN = (
    ("narx",),
    ("leaky_integrator_same_chosen", "leaky_integrator_same", "leaky_integrator"),
    ("vqf_same_chosen", "vqf_same", "vqf"),
    ("pseudo_integrator",),
    ("complementary_filter",),
)
_MOST_DRAWN = 6
_FURTHER_COLOURS = ("#bcbd22", "#17becf", "#7f7f7f", "#aec7e8", "#ffbb78", "#98df8a")
# of the forms of a method, which share its colour
_LINE_STYLES = ("-", ":", "-.", (0, (6.0, 1.0)))


# suffixes of row names (`narx.experiments.forms`), in the order of tables
_FORMS = ("", "_heading_zero", "_start_up", "_same")
_CHOSEN = "_chosen"
# what of the network's ingredients a method has, if not coupled axes with a start-up: a filter gets
# the start-up for the posture of its heading alone
_SAME = {
    "leaky_integrator": "tracker",
    "gyro_integration": "tracker",
    **dict.fromkeys(("vqf", "madgwick", "mahony"), "heading leak"),
}
BLOCKS = ("as printed", "same ingredients")


def _parts(row: str) -> tuple[str, str, bool]:
    """Split a row's name into method, form, and whether its parameters were chosen."""
    name = row.removesuffix(_CHOSEN)
    form = next((form for form in _FORMS[1:] if name.endswith(form)), "")
    return name.removesuffix(form), form, name != row


def method_block(row: str) -> str:
    """Return the block of the tables to which a row belongs.

    Parameters
    ----------
    row : str
        Name in ``results.csv``.

    Returns
    -------
    str
        ``as printed``, or ``same ingredients``: the network, and the methods with the same
        start-up, washout and heading leak as the network.
    """
    method, form, _ = _parts(row)
    same = form in ("_start_up", "_same") or method in ("narx", "narx_smoothed")
    return BLOCKS[int(same)]


def method_label(row: str, not_causal: Container[str] = ()) -> str:
    """Return the display name of a row.

    Parameters
    ----------
    row : str
        Name in ``results.csv``.
    not_causal : container of str
        Rows that use later samples; this is added to the name.

    Returns
    -------
    str
        Short name of the method (an unknown one as it is), how its heading is treated or that it
        has a start-up (and coupled axes), whether its parameters were chosen.
    """
    method, form, chosen = _parts(row)
    words = [_LABELS.get(method, method)]
    if form == "_heading_zero":
        words.append("heading 0")
    if form == "_start_up":
        words.append("start-up")
    if form == "_same":
        words.append(_SAME.get(method, "start-up"))
    if chosen:
        words.append("chosen")
    if row in not_causal:
        words.append("not causal")
    return ", ".join(words)


def method_order(rows: Iterable[str]) -> list[str]:
    """Sort rows: by block, then the methods of Tham et al. in their order, then the rest.

    Parameters
    ----------
    rows : iterable of str
        Names in ``results.csv``; each counts once.

    Returns
    -------
    list of str
        Known methods in the fixed order, unknown ones after them by name.
    """
    known = list(_LABELS)

    def place(row: str) -> tuple[object, ...]:
        method, form, chosen = _parts(row)
        at = known.index(method) if method in known else len(known)
        return BLOCKS.index(method_block(row)), at, method, _FORMS.index(form), chosen

    return sorted(set(rows), key=place)


def drawn_rows(rows: Iterable[str]) -> list[str]:
    """Choose the rows that a figure, or a table with many columns, shows.

    Parameters
    ----------
    rows : iterable of str
        Names in ``results.csv``; each counts once.

    Returns
    -------
    list of str
        All in the fixed order, if they are few; else those of a fixed choice that are there, or
        the first few.
    """
    ordered = method_order(rows)
    if len(ordered) <= _MOST_DRAWN:
        return ordered
    found = (next((row for row in rows if row in ordered), None) for rows in _DRAWN)
    return [row for row in found if row is not None] or ordered[:_MOST_DRAWN]


def method_colour(row: str) -> str:
    """Return the colour of a method.

    Parameters
    ----------
    row : str
        Name in ``results.csv``.

    Returns
    -------
    str
        Hexadecimal RGB, the same for all forms of a method; that of an unknown method is derived
        from its name.
    """
    method = _parts(row)[0]
    if method in _COLOURS:
        return _COLOURS[method]
    return _FURTHER_COLOURS[sum(method.encode()) % len(_FURTHER_COLOURS)]


def line_styles(rows: Iterable[str]) -> dict[str, str | tuple[int, tuple[float, ...]]]:
    """Choose a line style for each row of a figure, since the forms of a method share its colour.

    Parameters
    ----------
    rows : iterable of str
        Rows that are drawn together.

    Returns
    -------
    dict of str to line style of matplotlib
        Solid for the first form of each method; dashes are left to the reference.
    """
    forms: dict[str, int] = {}
    styles: dict[str, str | tuple[int, tuple[float, ...]]] = {}
    for row in dict.fromkeys(rows):
        colour = method_colour(row)
        styles[row] = _LINE_STYLES[forms.get(colour, 0) % len(_LINE_STYLES)]
        forms[colour] = forms.get(colour, 0) + 1
    return styles
