"""The sequence graph in ONNX: three parts that torch translates, in a Scan and a Loop.

torch can translate a loop in a scan as well, but it traces what is in them a dozen times for that.
"""

import copy
import logging
import warnings
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn

from narx.export.clocked import ClockedRecurrence
from narx.export.graph import INPUTS, OUTPUTS
from narx.inference.checkpoint import Checkpoint

# values that pass between the parts, by their names in the graph
_ARRIVE = ("inputs", "elapsed_s", "old_state"), (
    "there", "ticks", "back", "apart", "clock", "begun", "n_ticks",
)  # fmt: skip
_TICK = ("number", "ticks", "back", "apart", "inputs", "before"), ("after",)
_DEPART = ("there", "clock", "advanced"), (
    "next_state", "angles_of_sample", "std_of_sample", "quality_of_sample",
)  # fmt: skip


class _Arrive(nn.Module):
    def __init__(self, clocked: ClockedRecurrence) -> None:
        super().__init__()
        self.clocked = clocked

    def forward(self, inputs: Tensor, interval_s: Tensor, state: Tensor) -> tuple[Tensor, ...]:
        there, ticks, back, apart, lost, clock = self.clocked.arrive(inputs, interval_s, state)
        state = self.clocked.lose(lost, state)
        return there, ticks, back, apart, clock, state, self.clocked.most(ticks).to(torch.int64)


class _Tick(nn.Module):
    def __init__(self, clocked: ClockedRecurrence) -> None:
        super().__init__()
        self.clocked = clocked

    def forward(self, number: Tensor, *arguments: Tensor) -> Tensor:
        ticks = arguments[0]
        return self.clocked.tick(number.to(ticks.dtype) + 1.0, *arguments)


class _Depart(nn.Module):
    def __init__(self, clocked: ClockedRecurrence) -> None:
        super().__init__()
        self.clocked = clocked

    def forward(self, there: Tensor, clock: Tensor, state: Tensor) -> tuple[Tensor, ...]:
        angles, state = self.clocked.depart(there, clock, state)
        return state, angles, self.clocked.standard_deviation(state), self.clocked.quality(state)


def assembled(checkpoint: Checkpoint, dtype: torch.dtype) -> bytes:
    """Translate a network with its start-up or tracker.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    dtype : torch.dtype
        Type of all numbers.

    Returns
    -------
    bytes
        An ONNX model with the inputs and outputs of `narx.export.graph.SequenceGraph`.
    """
    import onnx
    from onnx import TensorProto, helper

    clocked = ClockedRecurrence(checkpoint).to(dtype).eval()
    real = TensorProto.DOUBLE if dtype == torch.float64 else TensorProto.FLOAT
    size, columns = clocked.state_size, clocked.n_inputs
    # one tensor for two inputs would be one input
    column, other, another, inputs, state, clock = (
        torch.zeros(2, width, dtype=dtype) for width in (1, 1, 1, columns, size, columns + 4)
    )
    number = torch.zeros((), dtype=torch.int64)
    arrive = _translated(_Arrive(clocked), (inputs, column, state), _ARRIVE)
    tick = _translated(_Tick(clocked), (number, column, other, another, inputs, state), _TICK)
    depart = _translated(_Depart(clocked), (column, clock, state), _DEPART)

    def value(name: str, *shape: int | str, kind: int = real) -> Any:
        return helper.make_tensor_value_info(name, kind, shape)

    loop = helper.make_graph(
        [helper.make_node("Identity", ["go_on"], ["goes_on"]), *tick.graph.node],
        "tick",
        [
            value("number", kind=TensorProto.INT64),
            value("go_on", kind=TensorProto.BOOL),
            value("before", "sensors", size),
        ],
        [value("goes_on", kind=TensorProto.BOOL), value("after", "sensors", size)],
    )
    scan = helper.make_graph(
        [
            *arrive.graph.node,
            helper.make_node("Loop", ["n_ticks", "", "begun"], ["advanced"], body=loop),
            *depart.graph.node,
        ],
        "sample",
        [
            value("old_state", "sensors", size),
            value("inputs", "sensors", columns),
            value("elapsed_s", "sensors", 1),
        ],
        [
            value("next_state", "sensors", size),
            value("angles_of_sample", "sensors", 3),
            value("std_of_sample", "sensors", 3),
            value("quality_of_sample", "sensors", kind=TensorProto.INT8),
        ],
    )
    rates, interval_s, begin = INPUTS
    angles, end, std_rad, quality = OUTPUTS
    by_sample = [f"{name}_by_sample" for name in (angles, std_rad, quality)]
    samples_first = [
        helper.make_node("Transpose", [rates], ["samples"], perm=[1, 0, 2]),
        helper.make_node("Transpose", [interval_s], ["intervals"], perm=[1, 0]),
        helper.make_node("Unsqueeze", ["intervals", "last_axis"], ["columns"]),
        helper.make_node(
            "Scan", [begin, "samples", "columns"], [end, *by_sample], body=scan, num_scan_inputs=2
        ),
        helper.make_node("Transpose", by_sample[:1], [angles], perm=[1, 0, 2]),
        helper.make_node("Transpose", by_sample[1:2], [std_rad], perm=[1, 0, 2]),
        helper.make_node("Transpose", by_sample[2:], [quality], perm=[1, 0]),
    ]
    last_axis = helper.make_tensor("last_axis", TensorProto.INT64, [1], [-1])
    constants = [c for part in (arrive, tick, depart) for c in part.graph.initializer]
    graph = helper.make_graph(
        samples_first,
        "narx",
        [
            value(rates, "sensors", "samples", columns),
            value(interval_s, "sensors", "samples"),
            value(begin, "sensors", size),
        ],
        [
            value(angles, "sensors", "samples", 3),
            value(end, "sensors", size),
            value(std_rad, "sensors", "samples", 3),
            value(quality, "sensors", "samples", kind=TensorProto.INT8),
        ],
        initializer=[last_axis, *constants],
    )
    model = helper.make_model(graph, opset_imports=tick.opset_import, ir_version=tick.ir_version)
    onnx.checker.check_model(model)
    return bytes(model.SerializeToString())


def _translated(
    module: nn.Module, example: tuple[Tensor, ...], names: tuple[Sequence[str], Sequence[str]]
) -> Any:
    """Translate a part; all values but its inputs and outputs get names of their own."""
    sensors = torch.export.Dim("sensors")
    shapes = tuple({0: sensors} if part.ndim else {} for part in example)
    # warnings about operators of packages that are not installed do not matter here
    for name in ("_registration", "_core"):
        logging.getLogger(f"torch.onnx._internal.exporter.{name}").setLevel(logging.ERROR)
    with torch.no_grad(), warnings.catch_warnings():
        # torch's exporter uses functions that torch itself deprecates
        warnings.simplefilter("ignore")
        program = torch.export.export(module, example, dynamic_shapes=_nested(module, shapes))
        translated = torch.onnx.export(
            program,
            input_names=names[0],
            output_names=names[1],
            dynamo=True,
            verbose=False,
            optimize=False,
        )
    assert translated is not None
    model = copy.deepcopy(translated.model_proto)
    own = type(module).__name__
    for node in model.graph.node:
        node.ClearField("metadata_props")
        node.ClearField("doc_string")
        node.ClearField("name")
        for values in (node.input, node.output):
            for i, value in enumerate(values):
                values[i] = _named(value, names, own)
    for constant in model.graph.initializer:
        constant.name = _named(constant.name, names, own)
    return model


def _nested(module: nn.Module, shapes: tuple[dict[int, Any], ...]) -> Any:
    # arguments that a signature gathers are one entry
    return (shapes[0], shapes[1:]) if isinstance(module, _Tick) else shapes


def _named(value: str, names: tuple[Sequence[str], Sequence[str]], own: str) -> str:
    return value if not value or value in names[0] or value in names[1] else f"{own}.{value}"
