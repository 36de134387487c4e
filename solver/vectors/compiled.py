"""Vectors inside kernels: the types of eight doubles and eight truths, and the code of what acts on their numbers."""

import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

from solver import vectors as plain
from solver.vectors import LANES

types: Any = numba_types  # whose names are made when it is imported

DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
LONGS = ir.VectorType(ir.IntType(64), LANES)
BITS = ir.VectorType(ir.IntType(1), LANES)
INDICES = ir.VectorType(ir.IntType(32), LANES)


class VectorType(types.Type):
    """Eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="Vector")


class MaskType(types.Type):
    """Eight booleans."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


class BareType(types.Type):
    """Where the numbers of an array stand, and how many a row has."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"Bare({dtype}, {ndim})")


VECTOR, MASK = VectorType(), MaskType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any):
        super().__init__(manager, kind, DOUBLES)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any):
        super().__init__(manager, kind, BITS)


@register_model(BareType)
class _BareModel(models.StructModel):
    def __init__(self, manager: Any, kind: Any):
        members = [("data", types.CPointer(kind.dtype)), ("columns", types.int64)]
        super().__init__(manager, kind, members)


def _splat(builder: Any, value: Any, kind: Any) -> Any:
    """A scalar in each lane."""
    single = builder.insert_element(ir.Constant(kind, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(INDICES, [ir.Constant(ir.IntType(32), 0)] * LANES)
    return builder.shuffle_vector(single, ir.Constant(kind, ir.Undefined), zeros)


@lower_cast(types.Float, VectorType)
@lower_cast(types.Integer, VectorType)
@lower_cast(types.IntegerLiteral, VectorType)
def spread_number(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    number = context.cast(builder, value, source, types.float64)
    return _splat(builder, number, DOUBLES)


@lower_cast(types.Boolean, MaskType)
@lower_cast(types.BooleanLiteral, MaskType)
def spread_truth(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return _splat(builder, builder.trunc(value, ir.IntType(1)) if value.type.width > 1 else value, BITS)


def is_number(kind: Any) -> bool:
    return isinstance(kind, (VectorType, types.Float, types.Integer))


def define(function: Any, choose: Any, emit: Any, *kinds: Any) -> None:
    """Type a function by ``choose(*types)``, a signature or None; ``emit`` makes its code for each of ``kinds``."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, arguments: Any, keywords: Any) -> Any:
            return None if keywords else choose(*arguments)

    infer_global(function)(Template) if isinstance(function, _BUILTIN) else infer_global(
        function, types.Function(Template)
    )
    for kind in kinds:
        lower_builtin(function, *kind)(emit)


_BUILTIN = type(operator.add)


def _arithmetic(function: Any, emit: Any, arity: int) -> None:
    """An operation of numbers, of which one at least is a vector."""

    def choose(*kinds: Any) -> Any:
        if len(kinds) == arity and VECTOR in kinds and all(map(is_number, kinds)):
            return signature(VECTOR, *(VECTOR,) * arity)
        return None

    define(function, choose, lambda c, b, s, a: emit(b, *a), (VectorType,) * arity)


_arithmetic(operator.add, lambda b, x, y: b.fadd(x, y), 2)
_arithmetic(operator.sub, lambda b, x, y: b.fsub(x, y), 2)
_arithmetic(operator.mul, lambda b, x, y: b.fmul(x, y), 2)
_arithmetic(operator.truediv, lambda b, x, y: b.fdiv(x, y), 2)
_arithmetic(operator.neg, lambda b, x: b.fneg(x), 1)


def _comparison(function: Any, symbol: str) -> None:
    def choose(value: Any, other: Any) -> Any:
        if VECTOR in (value, other) and is_number(value) and is_number(other):
            return signature(MASK, VECTOR, VECTOR)
        return None

    emit = lambda c, b, s, a: b.fcmp_ordered(symbol, *a)  # noqa: E731
    define(function, choose, emit, (VectorType, VectorType))


for _function, _symbol in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _comparison(_function, _symbol)


def _logic(function: Any, emit: Any, arity: int) -> None:
    def choose(*kinds: Any) -> Any:
        if MASK in kinds and all(isinstance(kind, (MaskType, types.Boolean)) for kind in kinds):
            return signature(MASK, *(MASK,) * arity)
        return None

    define(function, choose, lambda c, b, s, a: emit(b, *a), (MaskType,) * arity)


_logic(operator.and_, lambda b, x, y: b.and_(x, y), 2)
_logic(operator.or_, lambda b, x, y: b.or_(x, y), 2)
_logic(operator.invert, lambda b, x: b.not_(x), 1)


def _real(*kinds: Any) -> Any:
    """The type that numbers share: a vector where one of them is, else a double."""
    if not all(map(is_number, kinds)):
        return None
    return VECTOR if VECTOR in kinds else types.float64


def _choose_where(condition: Any, chosen: Any, other: Any) -> Any:
    value = _real(chosen, other)
    if value is None or not isinstance(condition, (MaskType, types.Boolean)):
        return None
    if isinstance(condition, MaskType):
        return signature(VECTOR, MASK, VECTOR, VECTOR)
    return signature(value, types.boolean, value, value)


def _truth(builder: Any, condition: Any) -> Any:
    if isinstance(condition.type, ir.IntType) and condition.type.width > 1:
        return builder.trunc(condition, ir.IntType(1))
    return condition


define(
    plain.where,
    _choose_where,
    lambda c, b, s, a: b.select(_truth(b, a[0]), a[1], a[2]),
    (MaskType, VectorType, VectorType),
    (types.Boolean, VectorType, VectorType),
    (types.Boolean, types.Float, types.Float),
)


def _elementary(function: Any, emit: Any, arity: int = 1) -> None:
    """A function of numbers, or of a vector and numbers."""

    def choose(*kinds: Any) -> Any:
        value = _real(*kinds) if len(kinds) == arity else None
        return None if value is None else signature(value, *(value,) * arity)

    define(function, choose, lambda c, b, s, a: emit(b, *a), (VectorType,) * arity, (types.Float,) * arity)


def _intrinsic(name: str) -> Any:
    def emit(builder: Any, value: Any) -> Any:
        suffix = "v8f64" if isinstance(value.type, ir.VectorType) else "f64"
        return builder.call(external(builder, f"{name}.{suffix}", [value.type], value.type), [value])

    return emit


def external(builder: Any, name: str, kinds: Any, result: Any) -> Any:
    return cgutils.get_or_insert_function(builder.module, ir.FunctionType(result, kinds), name)


def _integers(kind: Any) -> Any:
    """The integers of the same width as numbers of a type."""
    return LONGS if isinstance(kind, ir.VectorType) else ir.IntType(64)


def constant(kind: Any, value: Any) -> Any:
    """A number of a type, in each lane where it is a vector."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [ir.Constant(kind.element, value)] * LANES)
    return ir.Constant(kind, value)


_MANTISSA, _HALF, _BIAS = (1 << 52) - 1, 1022 << 52, 1022


def _emit_fraction(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    bits = builder.and_(builder.bitcast(value, whole), constant(whole, _MANTISSA))
    return builder.bitcast(builder.or_(bits, constant(whole, _HALF)), value.type)


def _emit_exponent(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    shifted = builder.lshr(builder.bitcast(value, whole), constant(whole, 52))
    return builder.sitofp(builder.sub(shifted, constant(whole, _BIAS)), value.type)


def _emit_power_of_two(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    number = builder.add(builder.fptosi(value, whole), constant(whole, _BIAS + 1))
    return builder.bitcast(builder.shl(number, constant(whole, 52)), value.type)


_elementary(plain.sqrt, _intrinsic("llvm.sqrt"))
_elementary(plain.floor, _intrinsic("llvm.floor"))
_elementary(plain.nearest, _intrinsic("llvm.rint"))
_elementary(plain.absolute, _intrinsic("llvm.fabs"))
_elementary(plain.fraction, _emit_fraction)
_elementary(plain.exponent, _emit_exponent)
_elementary(plain.power_of_two, _emit_power_of_two)
_elementary(plain.alike, lambda b, x, y: x, 2)
_elementary(plain.minimum, lambda b, x, y: b.select(b.fcmp_ordered("<", y, x), y, x), 2)
_elementary(plain.maximum, lambda b, x, y: b.select(b.fcmp_ordered(">", y, x), y, x), 2)


def _emit_finite(builder: Any, value: Any) -> Any:
    """|value| < infinity, false for NaN."""
    size = _intrinsic("llvm.fabs")(builder, value)
    return builder.fcmp_ordered("<", size, constant(value.type, float("inf")))


define(
    plain.finite,
    lambda kind: signature(MASK if kind is VECTOR else types.boolean, _real(kind)) if _real(kind) else None,
    lambda c, b, s, a: _emit_finite(b, a[0]),
    (VectorType,),
    (types.Float,),
)


def _emit_anywhere(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    (mask,) = arguments
    if sig.args[0] is not MASK:
        return mask
    bits = builder.bitcast(mask, ir.IntType(LANES))
    return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))


define(
    plain.anywhere,
    lambda kind: signature(types.boolean, kind) if isinstance(kind, (MaskType, types.Boolean)) else None,
    _emit_anywhere,
    (MaskType,),
    (types.Boolean,),
)


def _emit_counted(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    bits = builder.bitcast(arguments[0], ir.IntType(LANES))
    return builder.zext(builder.ctpop(bits), ir.IntType(64))


define(plain.counted, lambda kind: signature(types.int64, MASK) if kind is MASK else None, _emit_counted, (MaskType,))


def _emit_first_lanes(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    count = _splat(builder, arguments[0], LONGS)
    numbers = ir.Constant(LONGS, [ir.Constant(ir.IntType(64), lane) for lane in range(LANES)])
    return builder.icmp_signed("<", numbers, count)


define(
    plain.first_lanes,
    lambda kind: signature(MASK, types.int64) if isinstance(kind, types.Integer) else None,
    _emit_first_lanes,
    (types.Integer,),
)
define(
    plain.spread,
    lambda kind: signature(VECTOR, VECTOR) if is_number(kind) else None,
    lambda c, b, s, a: a[0],
    (VectorType,),
)
