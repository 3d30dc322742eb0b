"""TorchScript: one file for any process with torch, in Python or C++."""

import io
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import torch
from torch import Tensor, nn

from narx.export.clocked import ClockedRecurrence
from narx.inference.checkpoint import Checkpoint
from narx.kernels.limits import START_LIMIT_RAD

IDENTITY_FILE = "narx.json"
# torch writes the constants of a class in the order of a set, which differs between processes
_CONSTANTS = re.compile(rb"(?:^  \w+ : Final\[.*\n)+", re.MULTILINE)
# paths of sources, and a hash of the unordered content
_LEFT_OUT = (".debug_pkl", ".data/serialization_id")


class ScriptedNarx(nn.Module):
    """A trained network with its start-up and clock, for any batch of sensors.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.

    Attributes
    ----------
    sampling_rate_hz : float
        Sampling rate of the network, assumed for samples if no intervals are given.
    start_up_s : float
        Time in movement before the network takes over, s.
    n_inputs : int
        3, or 6 with the accelerometer.
    state_size : int
        Length of the state.
    """

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        self.clocked = ClockedRecurrence(checkpoint)
        self.sampling_rate_hz = float(checkpoint.model.sampling_rate_hz)
        self.start_up_s = float(checkpoint.start_up.duration_s)
        self.start_limit_rad = START_LIMIT_RAD
        self.n_inputs = self.clocked.n_inputs
        self.state_size = self.clocked.state_size

    @torch.jit.export
    def start(self, initial_angles: Tensor | None = None, batch: list[int] | None = None) -> Tensor:
        """Create the state before the first sample, on the device of the module.

        Parameters
        ----------
        initial_angles : Tensor, shape (..., 3), optional
            Known start pose, rad; standing upright is zero. None if it is unknown.
        batch : list of int, optional
            Leading dimensions of the state; by default those of the start pose.

        Returns
        -------
        Tensor, shape (..., state_size)
            State for `step`.

        Raises
        ------
        ValueError
            If the start pose is not three finite angles, of at most 1000 rad.
        """
        like = self.clocked.interval_s
        lead: list[int] = []
        if batch is not None:
            lead = batch
        elif initial_angles is not None:
            lead = list(initial_angles.shape[:-1])
        known = torch.zeros(lead, dtype=like.dtype, device=like.device).unsqueeze(-1)
        angles = torch.cat([known] * 3, dim=-1)
        if initial_angles is not None:
            usable = (torch.abs(initial_angles) <= self.start_limit_rad).all()
            if initial_angles.size(-1) != 3 or not bool(usable):
                raise ValueError("initial_angles: expected three finite angles in rad")
            angles = angles + initial_angles.to(dtype=like.dtype, device=like.device)
            known = known + 1.0
        return self.clocked.start(angles, known)

    @torch.jit.export
    def step(
        self, inputs: Tensor, state: Tensor, interval_s: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """Advance by one sample.

        Parameters
        ----------
        inputs : Tensor, shape (..., n_inputs)
            Gyroscope about the sagittal, frontal and transverse axis without bias, rad/s, and
            where `n_inputs` is 6 the specific force x, y, z, m/s^2; NaN where missing.
        state : Tensor, shape (..., state_size)
            From `start` or the previous sample; not changed.
        interval_s : Tensor, shape (...), optional
            Time since the previous sample, missing or not, s; by default the network's interval.

        Returns
        -------
        angles : Tensor, shape (..., 3)
            Sagittal, frontal and transverse angle, rad; NaN where the sample is missing.
        state : Tensor, shape (..., state_size)
            State for the next sample.

        Raises
        ------
        ValueError
            If a shape is wrong.
        """
        if inputs.size(-1) != self.n_inputs or state.size(-1) != self.state_size:
            raise ValueError(
                f"inputs have {inputs.size(-1)} columns and the state {state.size(-1)}, expected "
                f"{self.n_inputs} and {self.state_size}"
            )
        samples = inputs.to(state.dtype)
        intervals = torch.zeros_like(state[..., 0:1]) + self.clocked.interval_s
        if interval_s is not None:
            intervals = torch.zeros_like(intervals) + interval_s.to(state.dtype).unsqueeze(-1)
        there, ticks, back, apart, lost, clock = self.clocked.arrive(samples, intervals, state)
        state = self.clocked.lose(lost, state)
        number = torch.ones_like(self.clocked.interval_s)
        for _ in range(int(self.clocked.most(ticks))):
            state = self.clocked.tick(number, ticks, back, apart, samples, state)
            number = number + 1.0
        return self.clocked.depart(there, clock, state)

    @torch.jit.export
    def standard_deviation(self, state: Tensor) -> Tensor:
        """Give the standard deviations of the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            From `step`.

        Returns
        -------
        Tensor, shape (..., 3)
            rad; NaN where the sample is missing, or the network has none.
        """
        return self.clocked.standard_deviation(state)

    @torch.jit.export
    def quality(self, state: Tensor) -> Tensor:
        """Tell what the latest angles are worth.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            From `step`.

        Returns
        -------
        Tensor of int8, shape (...)
            0 good, 1 after a pause, 2 missing, 3 starting, 4 doubtful, as
            `narx.inference.stream.Quality`.
        """
        return self.clocked.quality(state)

    def forward(
        self,
        inputs: Tensor,
        initial_angles: Tensor | None = None,
        interval_s: Tensor | None = None,
    ) -> Tensor:
        """Run over whole recordings.

        Parameters
        ----------
        inputs : Tensor, shape (..., N, n_inputs)
            As for `step`.
        initial_angles : Tensor, shape (..., 3), optional
            As for `start`.
        interval_s : Tensor, shape (..., N), optional
            As for `step`.

        Returns
        -------
        Tensor, shape (..., N, 3)
            Angles, rad.

        Raises
        ------
        ValueError
            If a shape is wrong.
        """
        if inputs.dim() < 2 or inputs.size(-1) != self.n_inputs:
            raise ValueError(
                f"inputs have the shape {inputs.shape}, expected (..., N, {self.n_inputs})"
            )
        if interval_s is not None and interval_s.shape != inputs.shape[:-1]:
            raise ValueError(
                f"interval_s has the shape {interval_s.shape}, expected {inputs.shape[:-1]}"
            )
        state = self.start(initial_angles, list(inputs.shape[:-2]))
        angles = torch.zeros_like(inputs[..., :3], dtype=state.dtype, device=state.device)
        for k in range(inputs.shape[-2]):
            passed: Tensor | None = None
            if interval_s is not None:
                passed = interval_s[..., k]
            angles[..., k, :], state = self.step(inputs[..., k, :], state, passed)
        return angles


def build(checkpoint: Checkpoint, dtype: torch.dtype) -> bytes:
    """Compile a network.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    dtype : torch.dtype
        Type of all numbers.

    Returns
    -------
    bytes
        Content of the file, for `stamped`.
    """
    buffer = io.BytesIO()
    with _deprecation_ignored():
        script = torch.jit.script(ScriptedNarx(checkpoint).to(dtype).eval())
        torch.jit.save(script, buffer, _extra_files={IDENTITY_FILE: ""})
    return buffer.getvalue()


def stamped(data: bytes, identity: str) -> bytes:
    """Write the identity into a file saved by torch, and remove the paths of its sources.

    Parameters
    ----------
    data : bytes
        From ``torch.jit.save`` or ``torch.export.save``.
    identity : str
        Identity of the export.

    Returns
    -------
    bytes
        File with the same program. Its records have no date, so that the same program always gives
        the same bytes.
    """
    changed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(changed, "w") as other:
        for record in archive.infolist():
            name = record.filename
            if name.endswith(_LEFT_OUT):
                continue
            itself = name.endswith(f"extra/{IDENTITY_FILE}")
            content = identity.encode() if itself else archive.read(record)
            if name.endswith(".py"):
                content = _CONSTANTS.sub(_sorted_lines, content)
            other.writestr(zipfile.ZipInfo(name), content)
    return changed.getvalue()


def _sorted_lines(found: re.Match[bytes]) -> bytes:
    return b"".join(sorted(found[0].splitlines(keepends=True)))


def loaded(data: bytes) -> Callable[[Tensor, Tensor, Tensor | None], Tensor]:
    """Load a file to run it over recordings.

    Parameters
    ----------
    data : bytes
        From `build`.

    Returns
    -------
    callable
        From inputs (B, N, n_inputs), times since the previous samples (B, N), s, and known start
        poses (B, 3) or None to angles (B, N, 3), rad.
    """
    with _deprecation_ignored():
        module = torch.jit.load(io.BytesIO(data))

    def run(inputs: Tensor, interval_s: Tensor, start: Tensor | None) -> Tensor:
        with _deprecation_ignored():
            state = module.start(start, [len(inputs)])
        angles = torch.zeros_like(inputs[..., :3])
        with torch.no_grad():
            # torch compiles a step at its second call, a whole recording only after the first one
            for k in range(inputs.shape[1]):
                angles[:, k], state = module.step(inputs[:, k], state, interval_s[:, k])
        return angles

    return run


@contextmanager
def _deprecation_ignored() -> Iterator[None]:
    """Newer releases of torch recommend torch.export."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="`torch.jit.*` is deprecated")
        yield
