"""Eight numbers at a time: a vector type for kernels, and the elementary functions of the laws.

The laws are written once, without ``if``: ``where``, ``minimum`` and ``maximum`` choose, and the same text acts on a
number, on eight numbers inside a kernel, and on arrays of numpy in plain Python. Inside kernels eight doubles are one
value of the type ``Vector`` and eight truths one of the type ``Mask`` (LLVM's <8 x double> and <8 x i1>), because
numba's own loops over scalar text with calls and branches are not vectorised.

``bare``                an array without its reference count, which costs more than the work in inner loops
``load``, ``store``     eight neighbours in a row of a table, only the first so many of them
``line``, ``set_line``  the eight numbers of a row of a table with eight columns
``transposed``          eight vectors as a matrix, rows and columns changed over

A NaN stays visible: comparisons with it are false, and ``minimum`` and ``maximum`` keep one in their first argument.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

from solver.jit import device

LANES = 8

types: Any = numba_types  # whose names are made when it is imported

_DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
_LONGS = ir.VectorType(ir.IntType(64), LANES)
_BITS = ir.VectorType(ir.IntType(1), LANES)
_INDICES = ir.VectorType(ir.IntType(32), LANES)


# ---- plain Python: numbers and arrays of numpy ---------------------------------------------------


def where(condition, one, other):
    """``one`` where the condition holds, else ``other``."""
    return np.where(condition, one, other)[()]


def minimum(value, bound):
    """The smaller of two; NaN where the first is."""
    return where(bound < value, bound, value)


def maximum(value, bound):
    """The larger of two; NaN where the first is."""
    return where(bound > value, bound, value)


def absolute(value):
    """The value without its sign."""
    return np.abs(value)


def sqrt(value):
    """Square root; NaN below zero."""
    return np.sqrt(value)


def floor(value):
    """The largest whole number that is not larger."""
    return np.floor(value)


def nearest(value):
    """The nearest whole number."""
    return np.rint(value)


def fraction(value):
    """m of value = m 2^e with m in 1/2 .. 1, for normal positive numbers."""
    return np.frexp(value)[0]


def exponent(value):
    """e of value = m 2^e with m in 1/2 .. 1, for normal positive numbers."""
    return np.float64(1.0) * np.frexp(value)[1]


def power_of_two(exponent):
    """2^e of a whole number e within -1022 .. 1023."""
    return np.ldexp(1.0, np.asarray(exponent).astype(np.int64))[()]


def anywhere(condition):
    """Whether a condition holds for any of the numbers."""
    return bool(np.any(condition))


def counted(condition):
    """For how many of the numbers a condition holds."""
    return int(np.sum(condition))


def finite(value):
    """Whether a value is a number and not infinite."""
    return np.isfinite(value)


def first_lanes(count):
    """The mask of the first so many lanes; all of them from eight on."""
    return np.arange(LANES) < count


def alike(value, other):
    """The value as a number or as eight of them, as the other is."""
    return value + np.zeros(np.shape(other))[()]


def spread(value):
    """A number as a vector of eight."""
    return np.full(LANES, float(value))


def load(table, row, place, lanes):
    """Eight neighbours of a row of a table from a place on; zero where a lane is masked."""
    found = np.zeros(LANES)
    stop = min(place + LANES, table.shape[1])
    found[: stop - place] = table[row, place:stop]
    return np.where(lanes, found, 0.0)


def store(table, row, place, values, lanes):
    """Write eight neighbours of a row of a table from a place on, but for the masked lanes."""
    for lane in np.flatnonzero(lanes):
        table[row, place + lane] = np.broadcast_to(values, LANES)[lane]


def store_whole(places, place, values):
    """Write eight neighbours of a row of whole numbers, from a place on."""
    places[place : place + LANES] = np.broadcast_to(values, LANES).astype(np.int64)


def bare(array):
    """A contiguous array of one or two dimensions as inner loops take it; its owner must outlive it."""
    return array


def number(table, row, place):
    """One number of a table; no wrapping round of negative places."""
    return table[row, place]


def element(array, place):
    """One number of an array; no wrapping round of negative places."""
    return array[place]


def mark(flags, place):
    """Set one of an array of flags."""
    flags[place] = 1


def line(table, row):
    """The eight columns of a row of a table."""
    return table[row].copy()


def set_line(table, row, values):
    """Write the eight columns of a row of a table."""
    table[row] = values


def transposed(a, b, c, d, e, f, g, h):
    """The columns of the matrix whose rows are eight vectors."""
    return tuple(
        np.stack([np.broadcast_to(one, LANES) for one in (a, b, c, d, e, f, g, h)], axis=1)
    )


def largest(vector):
    """The largest of eight numbers; those that are none are passed over."""
    return float(np.fmax.reduce(np.broadcast_to(vector, LANES)))


def total(vector):
    """The sum of eight numbers."""
    return float(np.sum(np.broadcast_to(vector, LANES)))


# ---- elementary functions ------------------------------------------------------------------------

_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.44269504088896338700
SMALLEST = 2.2250738585072014e-308  # normal number
_LOWEST, _HIGHEST = -708.0, 709.0  # exponents of e whose powers are normal numbers


@device
def log(value):
    """Natural logarithm of a positive number, to one unit in the last place.

    ln(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + R)) with s = f / (2 + f), R an even polynomial in s; coefficients of
    fdlibm's ``e_log.c`` (Sun Microsystems, 1993).
    """
    part, power = fraction(value), exponent(value)
    low = part < 0.70710678118654752
    part = where(low, part + part, part)
    power = where(low, power - 1.0, power)
    f = part - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd = w * (
        3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01)
    )
    even = z * (
        6.666666666666735130e-01
        + w
        * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half = 0.5 * f * f
    found = power * _LN2_HIGH - ((half - (s * (half + (odd + even)) + power * _LN2_LOW)) - f)
    return where(finite(value), found, value)


@device
def exp(value):
    """e to a power, held within -708 .. 709; to two units in the last place.

    2^k times the Taylor polynomial of degree 13 of the rest r, |r| <= ln 2 / 2, whose error is 4e-18.
    """
    inside = minimum(maximum(value, _LOWEST), _HIGHEST)
    k = nearest(inside * _LOG2_E)
    r = (inside - k * _LN2_HIGH) - k * _LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    r8 = r4 * r4
    low = (1.0 + r) + r2 * (0.5 + r * 1.66666666666666666667e-01)
    second = (4.16666666666666666667e-02 + r * 8.33333333333333333333e-03) + r2 * (
        1.38888888888888888889e-03 + r * 1.98412698412698412698e-04
    )
    third = (2.48015873015873015873e-05 + r * 2.75573192239858906526e-06) + r2 * (
        2.75573192239858906526e-07 + r * 2.50521083854417187751e-08
    )
    last = 2.08767569878680989792e-09 + r * 1.60590438368216145994e-10
    return ((low + r4 * second) + r8 * (third + r4 * last)) * power_of_two(k)


@device
def power(base, exponent):
    """A number that is not negative to a power: e to the product with its logarithm.

    Zero to a power above zero is zero. Relative error: 1e-16 times the logarithm of the answer.
    """
    raised = exp(exponent * log(maximum(base, SMALLEST)))
    return where(base > 0.0, raised, where(exponent > 0.0, 0.0, 1.0) + 0.0 * base)


# ---- inside kernels: types ----------------------------------------------------------------------


class _VectorType(types.Type):
    """Eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="Vector")


class _MaskType(types.Type):
    """Eight truths."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


class _BareType(types.Type):
    """Where the numbers of an array stand, and how many a row has."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"Bare({dtype}, {ndim})")


VECTOR, MASK = _VectorType(), _MaskType()


@register_model(_VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any):
        super().__init__(manager, kind, _DOUBLES)


@register_model(_MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any):
        super().__init__(manager, kind, _BITS)


@register_model(_BareType)
class _BareModel(models.StructModel):
    def __init__(self, manager: Any, kind: Any):
        members = [("data", types.CPointer(kind.dtype)), ("columns", types.int64)]
        super().__init__(manager, kind, members)


def _splat(builder: Any, value: Any, kind: Any) -> Any:
    """A scalar in each lane."""
    single = builder.insert_element(
        ir.Constant(kind, ir.Undefined), value, ir.Constant(ir.IntType(32), 0)
    )
    zeros = ir.Constant(_INDICES, [ir.Constant(ir.IntType(32), 0)] * LANES)
    return builder.shuffle_vector(single, ir.Constant(kind, ir.Undefined), zeros)


@lower_cast(types.Float, _VectorType)
@lower_cast(types.Integer, _VectorType)
@lower_cast(types.IntegerLiteral, _VectorType)
def _(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    number = context.cast(builder, value, source, types.float64)
    return _splat(builder, number, _DOUBLES)


@lower_cast(types.Boolean, _MaskType)
@lower_cast(types.BooleanLiteral, _MaskType)
def _(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return _splat(
        builder, builder.trunc(value, ir.IntType(1)) if value.type.width > 1 else value, _BITS
    )


# ---- inside kernels: typing and code of each function ---------------------------------------------

_NUMBERS = (types.Number, types.IntegerLiteral)


def _is_number(kind: Any) -> bool:
    return isinstance(kind, (_VectorType, types.Float, types.Integer))


def _define(function: Any, choose: Any, emit: Any, *kinds: Any) -> None:
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
        if len(kinds) == arity and VECTOR in kinds and all(map(_is_number, kinds)):
            return signature(VECTOR, *(VECTOR,) * arity)
        return None

    _define(function, choose, lambda c, b, s, a: emit(b, *a), (_VectorType,) * arity)


_arithmetic(operator.add, lambda b, x, y: b.fadd(x, y), 2)
_arithmetic(operator.sub, lambda b, x, y: b.fsub(x, y), 2)
_arithmetic(operator.mul, lambda b, x, y: b.fmul(x, y), 2)
_arithmetic(operator.truediv, lambda b, x, y: b.fdiv(x, y), 2)
_arithmetic(operator.neg, lambda b, x: b.fneg(x), 1)


def _comparison(function: Any, symbol: str) -> None:
    def choose(one: Any, other: Any) -> Any:
        if VECTOR in (one, other) and _is_number(one) and _is_number(other):
            return signature(MASK, VECTOR, VECTOR)
        return None

    emit = lambda c, b, s, a: b.fcmp_ordered(symbol, *a)  # noqa: E731
    _define(function, choose, emit, (_VectorType, _VectorType))


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
        if MASK in kinds and all(isinstance(kind, (_MaskType, types.Boolean)) for kind in kinds):
            return signature(MASK, *(MASK,) * arity)
        return None

    _define(function, choose, lambda c, b, s, a: emit(b, *a), (_MaskType,) * arity)


_logic(operator.and_, lambda b, x, y: b.and_(x, y), 2)
_logic(operator.or_, lambda b, x, y: b.or_(x, y), 2)
_logic(operator.invert, lambda b, x: b.not_(x), 1)


def _real(*kinds: Any) -> Any:
    """The type that numbers share: a vector where one of them is, else a double."""
    if not all(map(_is_number, kinds)):
        return None
    return VECTOR if VECTOR in kinds else types.float64


def _choose_where(condition: Any, one: Any, other: Any) -> Any:
    value = _real(one, other)
    if value is None or not isinstance(condition, (_MaskType, types.Boolean)):
        return None
    if isinstance(condition, _MaskType):
        return signature(VECTOR, MASK, VECTOR, VECTOR)
    return signature(value, types.boolean, value, value)


def _truth(builder: Any, condition: Any) -> Any:
    if isinstance(condition.type, ir.IntType) and condition.type.width > 1:
        return builder.trunc(condition, ir.IntType(1))
    return condition


_define(
    where,
    _choose_where,
    lambda c, b, s, a: b.select(_truth(b, a[0]), a[1], a[2]),
    (_MaskType, _VectorType, _VectorType),
    (types.Boolean, _VectorType, _VectorType),
    (types.Boolean, types.Float, types.Float),
)


def _elementary(function: Any, emit: Any, arity: int = 1) -> None:
    """A function of numbers, or of a vector and numbers."""

    def choose(*kinds: Any) -> Any:
        value = _real(*kinds) if len(kinds) == arity else None
        return None if value is None else signature(value, *(value,) * arity)

    _define(
        function,
        choose,
        lambda c, b, s, a: emit(b, *a),
        (_VectorType,) * arity,
        (types.Float,) * arity,
    )


def _intrinsic(name: str) -> Any:
    def emit(builder: Any, value: Any) -> Any:
        suffix = "v8f64" if isinstance(value.type, ir.VectorType) else "f64"
        return builder.call(
            _external(builder, f"{name}.{suffix}", [value.type], value.type), [value]
        )

    return emit


def _external(builder: Any, name: str, kinds: Any, result: Any) -> Any:
    return cgutils.get_or_insert_function(builder.module, ir.FunctionType(result, kinds), name)


def _integers(kind: Any) -> Any:
    """The integers of the same width as numbers of a type."""
    return _LONGS if isinstance(kind, ir.VectorType) else ir.IntType(64)


def _constant(kind: Any, value: Any) -> Any:
    """A number of a type, in each lane where it is a vector."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [ir.Constant(kind.element, value)] * LANES)
    return ir.Constant(kind, value)


_MANTISSA, _HALF, _BIAS = (1 << 52) - 1, 1022 << 52, 1022


def _emit_fraction(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    bits = builder.and_(builder.bitcast(value, whole), _constant(whole, _MANTISSA))
    return builder.bitcast(builder.or_(bits, _constant(whole, _HALF)), value.type)


def _emit_exponent(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    shifted = builder.lshr(builder.bitcast(value, whole), _constant(whole, 52))
    return builder.sitofp(builder.sub(shifted, _constant(whole, _BIAS)), value.type)


def _emit_power_of_two(builder: Any, value: Any) -> Any:
    whole = _integers(value.type)
    number = builder.add(builder.fptosi(value, whole), _constant(whole, _BIAS + 1))
    return builder.bitcast(builder.shl(number, _constant(whole, 52)), value.type)


_elementary(sqrt, _intrinsic("llvm.sqrt"))
_elementary(floor, _intrinsic("llvm.floor"))
_elementary(nearest, _intrinsic("llvm.rint"))
_elementary(absolute, _intrinsic("llvm.fabs"))
_elementary(fraction, _emit_fraction)
_elementary(exponent, _emit_exponent)
_elementary(power_of_two, _emit_power_of_two)
_elementary(alike, lambda b, x, y: x, 2)
_elementary(minimum, lambda b, x, y: b.select(b.fcmp_ordered("<", y, x), y, x), 2)
_elementary(maximum, lambda b, x, y: b.select(b.fcmp_ordered(">", y, x), y, x), 2)


def _emit_finite(builder: Any, value: Any) -> Any:
    """|value| < infinity, false for NaN."""
    size = _intrinsic("llvm.fabs")(builder, value)
    return builder.fcmp_ordered("<", size, _constant(value.type, float("inf")))


_define(
    finite,
    lambda kind: (
        signature(MASK if kind is VECTOR else types.boolean, _real(kind)) if _real(kind) else None
    ),
    lambda c, b, s, a: _emit_finite(b, a[0]),
    (_VectorType,),
    (types.Float,),
)


def _emit_anywhere(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    (mask,) = arguments
    if sig.args[0] is not MASK:
        return mask
    bits = builder.bitcast(mask, ir.IntType(LANES))
    return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))


_define(
    anywhere,
    lambda kind: (
        signature(types.boolean, kind) if isinstance(kind, (_MaskType, types.Boolean)) else None
    ),
    _emit_anywhere,
    (_MaskType,),
    (types.Boolean,),
)


def _emit_counted(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    bits = builder.bitcast(arguments[0], ir.IntType(LANES))
    return builder.zext(builder.ctpop(bits), ir.IntType(64))


_define(
    counted,
    lambda kind: signature(types.int64, MASK) if kind is MASK else None,
    _emit_counted,
    (_MaskType,),
)


def _emit_first_lanes(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    count = _splat(builder, arguments[0], _LONGS)
    numbers = ir.Constant(_LONGS, [ir.Constant(ir.IntType(64), lane) for lane in range(LANES)])
    return builder.icmp_signed("<", numbers, count)


_define(
    first_lanes,
    lambda kind: signature(MASK, types.int64) if isinstance(kind, types.Integer) else None,
    _emit_first_lanes,
    (types.Integer,),
)
_define(
    spread,
    lambda kind: signature(VECTOR, VECTOR) if _is_number(kind) else None,
    lambda c, b, s, a: a[0],
    (_VectorType,),
)


# ---- inside kernels: memory ----------------------------------------------------------------------


def _address(context: Any, builder: Any, kind: Any, table: Any, row: Any, place: Any) -> Any:
    """Where table[row, place] stands; rows are contiguous. No wrapping round of negative numbers."""
    data, columns = _parts(context, builder, kind, table)
    if kind.ndim == 2:
        place = builder.add(builder.mul(row, columns), place)
    return builder.gep(data, [place])


def _parts(context: Any, builder: Any, kind: Any, array: Any) -> tuple[Any, Any]:
    """Where the numbers of an array stand, and how many a row has."""
    if isinstance(kind, _BareType):
        known = cgutils.create_struct_proxy(kind)(context, builder, value=array)
        return known.data, known.columns
    made = context.make_array(kind)(context, builder, array)
    return made.data, cgutils.unpack_tuple(builder, made.shape)[-1]


def _is_row(kind: Any) -> bool:
    return isinstance(kind, _BareType) or (isinstance(kind, types.Array) and kind.layout == "C")


def _is_table(kind: Any) -> bool:
    return _is_row(kind) and kind.ndim == 2


def _emit_bare(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    made = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    made.data, made.columns = _parts(context, builder, sig.args[0], arguments[0])
    return made._getvalue()


_define(
    bare,
    lambda kind: signature(_BareType(kind.dtype, kind.ndim), kind) if _is_row(kind) else None,
    _emit_bare,
    (types.Array,),
)


def _emit_load(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, place, lanes = arguments
    address = _address(context, builder, sig.args[0], table, row, place)
    address = builder.bitcast(address, _DOUBLES.as_pointer())
    kinds = [address.type, ir.IntType(32), _BITS, _DOUBLES]
    function = _external(builder, "llvm.masked.load.v8f64.p0", kinds, _DOUBLES)
    zeros = _constant(_DOUBLES, 0.0)
    return builder.call(function, [address, ir.Constant(ir.IntType(32), 8), lanes, zeros])


def _emit_store(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, place, values, lanes = arguments
    address = _address(context, builder, sig.args[0], table, row, place)
    address = builder.bitcast(address, _DOUBLES.as_pointer())
    kinds = [_DOUBLES, address.type, ir.IntType(32), _BITS]
    function = _external(builder, "llvm.masked.store.v8f64.p0", kinds, ir.VoidType())
    builder.call(function, [values, address, ir.Constant(ir.IntType(32), 8), lanes])
    return context.get_dummy_value()


_define(
    load,
    lambda table, row, place, lanes: (
        signature(VECTOR, table, types.int64, types.int64, MASK) if _is_table(table) else None
    ),
    _emit_load,
    (types.Array, types.Integer, types.Integer, _MaskType),
    (_BareType, types.Integer, types.Integer, _MaskType),
)
_define(
    store,
    lambda table, row, place, values, lanes: (
        signature(types.none, table, types.int64, types.int64, VECTOR, MASK)
        if _is_table(table) and _is_number(values)
        else None
    ),
    _emit_store,
    (types.Array, types.Integer, types.Integer, _VectorType, _MaskType),
    (_BareType, types.Integer, types.Integer, _VectorType, _MaskType),
)


def _emit_store_whole(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    places, place, values = arguments
    address = _address(context, builder, sig.args[0], places, None, place)
    address = builder.bitcast(address, _LONGS.as_pointer())
    builder.store(builder.fptosi(values, _LONGS), address, align=8)
    return context.get_dummy_value()


_define(
    store_whole,
    lambda places, place, values: signature(types.none, places, types.int64, VECTOR),
    _emit_store_whole,
    (types.Array, types.Integer, _VectorType),
    (_BareType, types.Integer, _VectorType),
)


def _emit_number(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return builder.load(_address(context, builder, sig.args[0], *arguments))


def _emit_element(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    array, place = arguments
    return builder.load(_address(context, builder, sig.args[0], array, None, place))


def _emit_mark(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    flags, place = arguments
    address = _address(context, builder, sig.args[0], flags, None, place)
    builder.store(ir.Constant(address.type.pointee, 1), address)
    return context.get_dummy_value()


_define(
    element,
    lambda array, place: signature(array.dtype, array, types.int64) if _is_row(array) else None,
    _emit_element,
    (types.Array, types.Integer),
    (_BareType, types.Integer),
)
_define(
    mark,
    lambda flags, place: signature(types.none, flags, types.int64) if _is_row(flags) else None,
    _emit_mark,
    (types.Array, types.Integer),
    (_BareType, types.Integer),
)
_define(
    number,
    lambda table, row, place: (
        signature(types.float64, table, types.int64, types.int64) if _is_table(table) else None
    ),
    _emit_number,
    (types.Array, types.Integer, types.Integer),
    (_BareType, types.Integer, types.Integer),
)


def _line_address(context: Any, builder: Any, kind: Any, table: Any, row: Any) -> Any:
    data, _ = _parts(context, builder, kind, table)
    place = builder.mul(row, ir.Constant(ir.IntType(64), LANES))
    return builder.bitcast(builder.gep(data, [place]), _DOUBLES.as_pointer())


def _emit_line(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return builder.load(_line_address(context, builder, sig.args[0], *arguments), align=8)


def _emit_set_line(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, values = arguments
    builder.store(values, _line_address(context, builder, sig.args[0], table, row), align=8)
    return context.get_dummy_value()


_define(
    line,
    lambda table, row: signature(VECTOR, table, types.int64) if _is_table(table) else None,
    _emit_line,
    (types.Array, types.Integer),
    (_BareType, types.Integer),
)
_define(
    set_line,
    lambda table, row, values: (
        signature(types.none, table, types.int64, VECTOR) if _is_table(table) else None
    ),
    _emit_set_line,
    (types.Array, types.Integer, _VectorType),
    (_BareType, types.Integer, _VectorType),
)


def _shuffled(builder: Any, one: Any, other: Any, places: Any) -> Any:
    mask = ir.Constant(_INDICES, [ir.Constant(ir.IntType(32), place) for place in places])
    return builder.shuffle_vector(one, other, mask)


def _emit_transposed(context: Any, builder: Any, sig: Any, rows: Any) -> Any:
    """Three rounds of exchanges between rows that are 1, 2 and 4 apart."""
    rows = list(rows)
    for apart in (1, 2, 4):
        low = [lane if not lane & apart else lane - apart + LANES for lane in range(LANES)]
        high = [lane + apart if not lane & apart else lane + LANES for lane in range(LANES)]
        for row in (one for one in range(LANES) if not one & apart):
            first, second = rows[row], rows[row + apart]
            rows[row] = _shuffled(builder, first, second, low)
            rows[row + apart] = _shuffled(builder, first, second, high)
    return context.make_tuple(builder, sig.return_type, rows)


_define(
    transposed,
    lambda *rows: (
        signature(types.UniTuple(VECTOR, LANES), *(VECTOR,) * LANES)
        if all(map(_is_number, rows))
        else None
    ),
    _emit_transposed,
    (_VectorType,) * LANES,
)


def _reduction(function: Any, combine: Any) -> None:
    """Halves against halves, so that the order does not depend on the machine."""

    def emit(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        (value,) = arguments
        for apart in (4, 2, 1):
            other = _shuffled(
                builder, value, value, [(lane + apart) % LANES for lane in range(LANES)]
            )
            value = combine(builder, value, other)
        return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

    _define(
        function,
        lambda kind: signature(types.float64, VECTOR) if _is_number(kind) else None,
        emit,
        (_VectorType,),
    )


def _larger(builder: Any, one: Any, other: Any) -> Any:
    function = _external(builder, "llvm.maxnum.v8f64", [_DOUBLES, _DOUBLES], _DOUBLES)
    return builder.call(function, [one, other])


_reduction(largest, _larger)
_reduction(total, lambda b, x, y: b.fadd(x, y))
