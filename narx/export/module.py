"""Which module carries a checkpoint: with its tracker, or with the start-up of before."""

from narx.export.recurrence import ExportedNarx, StepGraph
from narx.export.recurrence import description as start_up_description
from narx.export.tracked import ExportedTracked, TrackedStep
from narx.inference.checkpoint import Checkpoint


def exported(checkpoint: Checkpoint) -> ExportedNarx | ExportedTracked:
    """Make the scriptable module of a checkpoint.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.

    Returns
    -------
    ExportedNarx or ExportedTracked
        With `start`, `step` and a call over a whole recording.
    """
    if checkpoint.tracker is None:
        return ExportedNarx(checkpoint)
    return ExportedTracked(checkpoint)


def graph(narx: ExportedNarx | ExportedTracked) -> StepGraph | TrackedStep:
    """Return the step as a module without a branch, for formats that hold a graph.

    Parameters
    ----------
    narx : ExportedNarx or ExportedTracked
        From `exported`.

    Returns
    -------
    StepGraph or TrackedStep
        ``(inputs, state) -> (angles, state)``.
    """
    return narx.one_step if isinstance(narx, ExportedTracked) else StepGraph(narx)


def description(narx: ExportedNarx | ExportedTracked) -> dict[str, object]:
    """Say what a user of the bare step must know.

    Parameters
    ----------
    narx : ExportedNarx or ExportedTracked
        From `exported`.

    Returns
    -------
    dict
        Plain numbers and strings: rate, units and the state to start from.
    """
    if isinstance(narx, ExportedNarx):
        return start_up_description(narx)
    last = narx.state_size - 3 * narx.n_outputs
    return {
        "sampling_rate_hz": narx.sampling_rate_hz,
        "axes": "sagittal, frontal, transverse",
        "axis_rates_unit": "rad/s",
        "angles_unit": "rad",
        "inputs": "axis rates, then specific force x, y, z in m/s^2"
        if narx.n_inputs == 6
        else "axis rates",
        "start_state": narx.start().tolist(),
        "known_start_state": narx.known_start.tolist(),
        "known_start": "known_start_state, with the three start angles in state[0:3] and each "
        f"{narx.n_outputs} times from state[{last}]",
    }
