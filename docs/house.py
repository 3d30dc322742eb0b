"""Draw `figures/house.svg`: the sub-packages on their levels (run it after a move)."""

from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

# from the bottom: a room imports from the floors below it alone (tests/test_architecture.py)
FLOORS = (
    (("errors", "files", "types"), ("one-line errors", "complete files or none", "array types")),
    (
        ("kernels", "missing", "settings"),
        ("all compiled code, one cache stamp", "rows without missing values", "checks of settings"),
    ),
    (
        ("kinematics", "recursion"),
        ("frames, signs, rotations, joint angles", "interface of recursions"),
    ),
    (
        ("recordings", "method", "network"),
        ("sensors on one clock", "interface of all methods", "the NARX network, closed loop"),
    ),
    (
        ("simulation", "gait", "calibration", "windows"),
        ("virtual walkers", "strides, phases, rest", "sensor-segment alignment", "lagged windows"),
    ),
    (("datasets", "inference"), ("sources and splits", "running a trained network")),
    (("baselines",), ("established methods",)),
    (("training", "export"), ("objective, optimisers, teachers", "TorchScript, ONNX, C")),
    (("evaluation",), ("agreement with the reference, statistics",)),
    (("experiments",), ("commands, tables, figures, reports",)),
)
WIDTH, HEIGHT, GAP = 12.0, 0.8, 0.25


def house() -> Figure:
    """Draw the floors.

    Returns
    -------
    matplotlib.figure.Figure
        Rooms as boxes, the flow of data from bottom to top.
    """
    figure = Figure(figsize=(9.0, 7.5))
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    for floor, (rooms, what) in enumerate(FLOORS):
        width = (WIDTH - GAP * (len(rooms) - 1)) / len(rooms)
        for k, (room, text) in enumerate(zip(rooms, what, strict=True)):
            x, y = k * (width + GAP), floor * (HEIGHT + GAP)
            style = "round,pad=0,rounding_size=0.08"
            colour = mpl.colormaps["Blues"](0.1 + 0.05 * floor)
            box = FancyBboxPatch((x, y), width, HEIGHT, boxstyle=style, fc=colour, ec="0.4")
            axes.add_patch(box)
            middle = x + width / 2
            axes.text(middle, y + 0.52, room, ha="center", va="center", weight="bold", size=12)
            axes.text(middle, y + 0.2, text, ha="center", va="center", size=9)
    axes.set(xlim=(-0.1, WIDTH + 0.1), ylim=(-0.1, len(FLOORS) * (HEIGHT + GAP)))
    axes.set_axis_off()
    return figure


if __name__ == "__main__":
    mpl.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "house"})
    path = Path(__file__).parent / "figures" / "house.svg"
    house().savefig(path, metadata={"Date": None})
