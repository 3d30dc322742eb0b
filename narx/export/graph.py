"""Whole sequences of many sensors as one graph of operations, for torch.export."""

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor, nn
from torch._higher_order_ops.scan import scan_op
from torch._higher_order_ops.while_loop import while_loop_op

from narx.export.clocked import ClockedRecurrence
from narx.inference.checkpoint import Checkpoint

# (axis_rates (B, N, C), interval_s (B, N), state (B, S)) -> angles (B, N, 3), new state (B, S)
GraphRunner = Callable[[Tensor, Tensor, Tensor], tuple[Tensor, Tensor]]
INPUTS = ("axis_rates", "interval_s", "state")
OUTPUTS = ("angles", "new_state", "std_rad", "quality")


class SequenceGraph(nn.Module):
    """The clocked recurrence over N samples of B sensors: a scan over samples, a loop over ticks.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    """

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        self.clocked = ClockedRecurrence(checkpoint)

    def forward(
        self, axis_rates: Tensor, interval_s: Tensor, state: Tensor
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Advance by N samples.

        Parameters
        ----------
        axis_rates : Tensor, shape (B, N, n_inputs)
            Gyroscope about the sagittal, frontal and transverse axis without bias, rad/s, and
            where there are six inputs the specific force x, y, z, m/s^2; NaN where missing.
        interval_s : Tensor, shape (B, N)
            Time since the previous sample, missing or not, s.
        state : Tensor, shape (B, state_size)
            Initial state, or that of the previous call.

        Returns
        -------
        angles : Tensor, shape (B, N, 3)
            Sagittal, frontal and transverse angle, rad; NaN where the sample is missing.
        new_state : Tensor, shape (B, state_size)
            State for the next call.
        std_rad : Tensor, shape (B, N, 3)
            Standard deviations of the angles, rad; NaN where the sample is missing, or the network
            has none.
        quality : Tensor of int8, shape (B, N)
            A `narx.inference.stream.Quality`.
        """
        buffers = tuple(self.clocked.buffers())

        def sample(state: Tensor, arriving: Tensor, *buffers: Tensor) -> tuple[Tensor, ...]:
            # the operators of higher order want no two of their inputs in one memory
            inputs = arriving[..., :-1].clone()
            there, ticks, back, apart, lost, clock = self._call(
                "arrive", buffers, inputs, arriving[..., -1:], state
            )
            state = self._call("lose", buffers, lost, state)
            first = torch.ones((), dtype=state.dtype, device=state.device)
            constant = (ticks, back, apart, inputs, *buffers)
            begun: Any = (first, state)
            _, state = while_loop_op(due, tick, begun, constant)
            angles, state = self._call("depart", buffers, there, clock, state)
            std_rad = self._call("standard_deviation", buffers, state)
            return state, angles, std_rad, self._call("quality", buffers, state)

        def due(number: Tensor, state: Tensor, ticks: Tensor, *_: Tensor) -> Tensor:
            return number <= self.clocked.most(ticks)

        def tick(number: Tensor, state: Tensor, *constant: Tensor) -> tuple[Tensor, Tensor]:
            moved = self._call("tick", constant[4:], number, *constant[:4], state)
            return number + 1.0, moved

        arriving = torch.cat([axis_rates, interval_s.unsqueeze(-1)], dim=-1).transpose(0, 1)
        # the operators themselves: the functions `scan` and `while_loop` trace everything twice
        state, *outputs = scan_op(sample, [state], [arriving], additional_inputs=buffers)
        angles, std_rad, quality = (output.transpose(0, 1) for output in outputs)
        return angles, state, std_rad, quality

    def _call(self, name: str, buffers: tuple[Tensor, ...], *arguments: Tensor) -> Any:
        """Call a method of the recurrence with its buffers as inputs of an operator."""
        modules, own = self.clocked.modules(), tuple(self.clocked.buffers())
        places = [(m, buffer) for m in modules for buffer, _ in m.named_buffers(recurse=False)]
        try:
            for (module, buffer), value in zip(places, buffers, strict=True):
                setattr(module, buffer, value)
            return getattr(self.clocked, name)(*arguments)
        finally:
            for (module, buffer), value in zip(places, own, strict=True):
                setattr(module, buffer, value)

    def example(self, dtype: torch.dtype) -> tuple[Tensor, Tensor, Tensor]:
        """Create example inputs for tracing the graph.

        Parameters
        ----------
        dtype : torch.dtype
            Type of all numbers.

        Returns
        -------
        axis_rates, interval_s, state : Tensor
            Inputs of three samples of two sensors.
        """
        start = self.clocked.start(torch.zeros(2, 3, dtype=dtype), torch.zeros(2, 1, dtype=dtype))
        interval_s = self.clocked.interval_s.expand(2, 3).clone()
        rates = torch.zeros(2, 3, self.clocked.n_inputs, dtype=dtype)
        return rates, interval_s, start


def program(checkpoint: Checkpoint, dtype: torch.dtype) -> torch.export.ExportedProgram:
    """Trace the graph for any number of sensors and samples.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    dtype : torch.dtype
        Type of all numbers.

    Returns
    -------
    torch.export.ExportedProgram
        As `SequenceGraph`, without a word on where its source lies.
    """
    graph = SequenceGraph(checkpoint).to(dtype).eval()
    sensors, samples = torch.export.Dim("sensors"), torch.export.Dim("samples")
    shapes = ({0: sensors, 1: samples}, {0: sensors, 1: samples}, {0: sensors})
    with torch.no_grad():
        exported = torch.export.export(graph, graph.example(dtype), dynamic_shapes=shapes)
    for module in exported.graph_module.modules():
        for node in getattr(module, "graph", torch.fx.Graph()).nodes:
            for key in ("stack_trace", "nn_module_stack", "source_fn_stack", "from_node"):
                node.meta.pop(key, None)
    return exported
