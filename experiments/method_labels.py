"""How methods are called, ordered and coloured, the same in every table and figure."""

from collections.abc import Iterable

_LABELS = {
    "complementary_filter": "CF",
    "complementary_filter_real_time": "CF real time",
    "narx": "NARX",
    "narx_smoothed": "NARX smoothed",
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

# NARX red, PI green, CF blue as in Tham et al., Fig. 6; the others apart from these and from each
# other, also for colour-blind eyes (Okabe and Ito)
_COLOURS = {
    "narx": "#c8102e",
    "narx_smoothed": "#f28e8e",
    "pseudo_integrator": "#009e73",
    "complementary_filter": "#0060b0",
    "gyro_integration": "#e69f00",
    "giof": "#cc79a7",
    "giof_two_strides": "#8b3a62",
    "giof_as_printed": "#999933",
    "giof_real_time": "#d55e00",
    "complementary_filter_real_time": "#6fa8dc",
    "two_point": "#7b3fa0",
    "vqf": "#222222",
    "vqf_offline": "#777777",
    "madgwick": "#56b4e9",
    "mahony": "#8c6d31",
    "leaky_integrator": "#b2182b",
    "strapdown": "#fdae61",
    "constant": "#c0c0c0",
    "zero": "#e0e0e0",
}
_FURTHER_COLOURS = ("#bcbd22", "#17becf", "#7f7f7f", "#aec7e8", "#ffbb78", "#98df8a")


def method_label(method: str) -> str:
    """Return the name of a method for people.

    Parameters
    ----------
    method : str
        Name in ``results.csv``.

    Returns
    -------
    str
        Short name; an unknown one is returned as it is.
    """
    return _LABELS.get(method, method)


def method_order(methods: Iterable[str]) -> list[str]:
    """Sort methods: the three of Tham et al. in their order, then the rest.

    Parameters
    ----------
    methods : iterable of str
        Names in ``results.csv``; each counts once.

    Returns
    -------
    list of str
        Known methods in the fixed order, unknown ones after them by name.
    """
    known = list(_LABELS)
    return sorted(set(methods), key=lambda m: (known.index(m) if m in known else len(known), m))


def method_colour(method: str) -> str:
    """Return the colour of a method.

    Parameters
    ----------
    method : str
        Name in ``results.csv``.

    Returns
    -------
    str
        Hexadecimal RGB; an unknown method gets one that depends on its name alone.
    """
    if method in _COLOURS:
        return _COLOURS[method]
    return _FURTHER_COLOURS[sum(method.encode()) % len(_FURTHER_COLOURS)]
