"""Explicit vectors for numba: one kernel source for one sequence and for several in parallel.

A recurrence cannot be vectorised over time, but many of them can run side by side: restarts of
a training, channels of a recording. Compilers rarely vectorise this (aliasing, short inner loops),
so the kernels do it explicitly: `load` returns a vector of `width` contiguous float64 (a plain
float64 for a width of one), the operators work on it, `store` writes it back. LLVM splits a vector
into the registers of the machine.

Lanes, and the sizes of the default network, reach the kernels as lengths of tuples: a length is
part of a tuple's type, so loops over them have a bound known at compile time.
"""

import math
import operator
from typing import Any

from narx.kernels.numba_internals import (
    AbstractTemplate,
    cgutils,
    infer_global,
    ir,
    lower_builtin,
    models,
    register_model,
    signature,
    types,
)
from narx.kernels.numba_internals import intrinsic as _intrinsic
from narx.kernels.numba_internals import overload as _overload

# these decorators change the signature of a function, which mypy cannot follow
intrinsic: Any = _intrinsic
overload: Any = _overload


class Vector(types.Type):
    """Numba type of `width` float64 in one value."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Vector({width})")


@register_model(Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Vector) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.DoubleType(), fe_type.width))


def _value_type(width: int) -> types.Type:
    return types.float64 if width == 1 else Vector(width)


def _splat(builder: ir.IRBuilder, value: ir.Value, width: int) -> ir.Value:
    vector = ir.VectorType(ir.DoubleType(), width)
    index = ir.Constant(ir.IntType(32), 0)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, index)
    mask = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(one, one, mask)


_OPERATIONS = {
    operator.add: "fadd",
    operator.sub: "fsub",
    operator.mul: "fmul",
    operator.truediv: "fdiv",
}


class _VectorArithmetic(AbstractTemplate):
    def generic(self, args: tuple[types.Type, ...], kws: dict[str, Any]) -> Any:
        if len(args) != 2 or not any(isinstance(a, Vector) for a in args):
            return None
        vector = next(a for a in args if isinstance(a, Vector))
        wanted = [a if isinstance(a, Vector) else types.float64 for a in args]
        return signature(vector, *wanted)


def _lower(function: Any, instruction: str) -> None:
    infer_global(function)(_VectorArithmetic)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        width = sig.return_type.width
        left, right = (
            arg if isinstance(ty, Vector) else _splat(builder, arg, width)
            for arg, ty in zip(args, sig.args, strict=True)
        )
        # without flags of its own: those of the function apply, as to single numbers
        return getattr(builder, instruction)(left, right)

    for a, b in ((Vector, Vector), (Vector, types.Float), (types.Float, Vector)):
        lower_builtin(function, a, b)(lower)


for _function, _instruction in _OPERATIONS.items():
    _lower(_function, _instruction)


def _pointer(context: Any, builder: Any, sig: Any, array: Any, index: Any, width: int) -> Any:
    array_type, index_type = sig.args[1], sig.args[2]
    view = context.make_array(array_type)(context, builder, array)
    position = cgutils.unpack_tuple(builder, index, len(index_type))
    position = [
        context.cast(builder, i, ty, types.intp) for i, ty in zip(position, index_type, strict=True)
    ]
    pointer = cgutils.get_item_pointer(
        context, builder, array_type, view, position, wraparound=False, boundscheck=False
    )
    if width == 1:
        return pointer
    return builder.bitcast(pointer, ir.VectorType(ir.DoubleType(), width).as_pointer())


@intrinsic
def load(typingctx: Any, lanes: Any, array: Any, index: Any) -> Any:
    """Read one number per lane, contiguous from ``array[index]`` on."""
    width = len(lanes)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        pointer = _pointer(context, builder, sig, args[1], args[2], width)
        return builder.load(pointer, align=8)

    return _value_type(width)(lanes, array, index), codegen


@intrinsic
def spread(typingctx: Any, lanes: Any, array_lanes: Any, array: Any, index: Any) -> Any:
    """Read as `load` does, or broadcast a single number to all lanes."""
    width, array_width = len(lanes), len(array_lanes)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        inner = sig.return_type(lanes, array, index)
        pointer = _pointer(context, builder, inner, args[2], args[3], array_width)
        value = builder.load(pointer, align=8)
        return _splat(builder, value, width) if array_width < width else value

    return _value_type(width)(lanes, array_lanes, array, index), codegen


@intrinsic
def store(typingctx: Any, lanes: Any, array: Any, index: Any, value: Any) -> Any:
    """Write contiguous numbers from ``array[index]`` on."""
    width = len(lanes)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        pointer = _pointer(context, builder, sig, args[1], args[2], width)
        builder.store(args[3], pointer, align=8)
        return context.get_dummy_value()

    return types.void(lanes, array, index, _value_type(width)), codegen


@intrinsic
def splat(typingctx: Any, lanes: Any, value: Any) -> Any:
    """Broadcast one number to all lanes."""
    width = len(lanes)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        return args[1] if width == 1 else _splat(builder, args[1], width)

    return _value_type(width)(lanes, types.float64), codegen


@intrinsic
def clamp(typingctx: Any, value: Any, limit: Any) -> Any:
    """Limit to +-limit; NaN stays NaN."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        x, high = args
        low = builder.fsub(ir.Constant(high.type, 0.0), high)
        if isinstance(sig.args[0], Vector):
            high, low = (_splat(builder, v, sig.args[0].width) for v in (high, low))
        x = builder.select(builder.fcmp_ordered(">", x, high), high, x)
        return builder.select(builder.fcmp_ordered("<", x, low), low, x)

    return value(value, types.float64), codegen


def _by_llvm(name: str) -> Any:
    """Build an intrinsic of one floating-point argument from LLVM's intrinsic of that name."""

    def typed(typingctx: Any, x: Any) -> Any:
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
            kind = args[0].type
            suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
            function = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(kind, [kind]), f"llvm.{name}.{suffix}"
            )
            return builder.call(function, args)

        return x(x), codegen

    return intrinsic(typed)


nearest = _by_llvm("rint")
magnitude = _by_llvm("fabs")


@intrinsic
def where_less(typingctx: Any, x: Any, limit: Any, yes: Any, no: Any) -> Any:
    """Choose lane by lane: `yes` where x < limit, else `no` (also if x is NaN)."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        return builder.select(builder.fcmp_ordered("<", args[0], args[1]), args[2], args[3])

    return x(x, x, x, x), codegen


@intrinsic
def _lane(typingctx: Any, value: Any, index: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        return builder.extract_element(args[0], args[1])

    return types.float64(value, index), codegen


@intrinsic
def _with_lane(typingctx: Any, value: Any, index: Any, number: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> ir.Value:
        return builder.insert_element(args[0], args[2], args[1])

    return value(value, index, types.float64), codegen


def _by_lane(function: Any) -> Any:
    """Build a function that applies one of numba's to every lane."""

    def placeholder(x: Any) -> Any:
        raise NotImplementedError

    @overload(placeholder)
    def _typed(x: Any) -> Any:
        if not isinstance(x, Vector):

            def alone(x: Any) -> Any:
                return function(x)

            return alone
        width = x.width

        def by_lane(x: Any) -> Any:
            for lane in range(width):
                x = _with_lane(x, lane, function(_lane(x, lane)))
            return x

        return by_lane

    return placeholder


exact_tanh = _by_lane(math.tanh)
exact_sin = _by_lane(math.sin)
exact_cos = _by_lane(math.cos)


__all__ = [
    "clamp",
    "exact_cos",
    "exact_sin",
    "exact_tanh",
    "load",
    "magnitude",
    "nearest",
    "splat",
    "spread",
    "store",
    "where_less",
]
