"""Vectors inside kernels: the types of eight doubles and eight truths, and the code of the functions of this package.

``define`` gives numba the type of a function's result and who emits its code. An emitter that acts on numbers takes
LLVM's builder and the values; any other takes what ``numba.extending.lower_builtin`` calls it with: context, builder,
signature and values.
"""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.types.containers import UniTuple
from numba.core.types.misc import CPointer
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

from solver import vectors as plain
from solver.vectors import LANES

DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
LONGS = ir.VectorType(ir.IntType(64), LANES)
BITS = ir.VectorType(ir.IntType(1), LANES)
INDICES = ir.VectorType(ir.IntType(32), LANES)
ALIGNED = ir.Constant(ir.IntType(32), 8)  # bytes: no more than a double is


class VectorType(types.Type):
    """Eight doubles."""

    def __init__(self):
        super().__init__(name="Vector")


class MaskType(types.Type):
    """Eight booleans."""

    def __init__(self):
        super().__init__(name="Mask")


class BareType(types.Type):
    """Where the numbers of an array stand, and how many a row has."""

    def __init__(self, dtype, ndim):
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"Bare({dtype}, {ndim})")


VECTOR, MASK = VectorType(), MaskType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, DOUBLES)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, BITS)


@register_model(BareType)
class _BareModel(models.StructModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, [("data", CPointer(kind.dtype)), ("columns", types.int64)])


def _splat(builder, value, kind):
    """A scalar in each lane."""
    single = builder.insert_element(ir.Constant(kind, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(INDICES, [ir.Constant(ir.IntType(32), 0)] * LANES)
    return builder.shuffle_vector(single, ir.Constant(kind, ir.Undefined), zeros)


@lower_cast(types.Float, VectorType)
@lower_cast(types.Integer, VectorType)
@lower_cast(types.IntegerLiteral, VectorType)
def _spread_number(context, builder, source, target, value):
    return _splat(builder, context.cast(builder, value, source, types.float64), DOUBLES)


@lower_cast(types.Boolean, MaskType)
@lower_cast(types.BooleanLiteral, MaskType)
def _spread_truth(context, builder, source, target, value):
    return _splat(builder, _truth(builder, value), BITS)


def _truth(builder, condition):
    """A condition as one bit, or one a lane."""
    if isinstance(condition.type, ir.IntType) and condition.type.width > 1:
        return builder.trunc(condition, ir.IntType(1))
    return condition


def _is_number(kind):
    return isinstance(kind, (VectorType, types.Float, types.Integer))


def _is_truth(kind):
    return isinstance(kind, (MaskType, types.Boolean))


def define(function, choose, emit, *kinds):
    """Type a function by ``choose(*types)``, a signature or None; ``emit`` makes its code for each of ``kinds``."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, arguments, keywords):
            return None if keywords else choose(*arguments)

    if isinstance(function, type(operator.add)):
        infer_global(function)(Template)
    else:
        infer_global(function, types.Function(Template))
    for kind in kinds:
        lower_builtin(function, *kind)(emit)


# Operators, where one operand at least is a vector or a mask, and functions of numbers -------------------------------


def _operator(function, emit, arity, operand, result, accepts):
    def choose(*kinds):
        if operand in kinds and all(map(accepts, kinds)):
            return signature(result, *(operand,) * arity)
        return None

    define(function, choose, lambda c, b, s, values: emit(b, *values), (type(operand),) * arity)


for _function, _emit, _arity in (
    (operator.add, ir.IRBuilder.fadd, 2),
    (operator.sub, ir.IRBuilder.fsub, 2),
    (operator.mul, ir.IRBuilder.fmul, 2),
    (operator.truediv, ir.IRBuilder.fdiv, 2),
    (operator.neg, ir.IRBuilder.fneg, 1),
):
    _operator(_function, _emit, _arity, VECTOR, VECTOR, _is_number)


def _ordered(symbol):
    """A comparison that is false for NaN."""
    return lambda builder, value, other: builder.fcmp_ordered(symbol, value, other)


for _function, _symbol in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _operator(_function, _ordered(_symbol), 2, VECTOR, MASK, _is_number)

_operator(operator.and_, ir.IRBuilder.and_, 2, MASK, MASK, _is_truth)
_operator(operator.or_, ir.IRBuilder.or_, 2, MASK, MASK, _is_truth)
_operator(operator.invert, ir.IRBuilder.not_, 1, MASK, MASK, _is_truth)


def _shared(*kinds):
    """The type that numbers share: a vector where one of them is, else a double; None of others."""
    if not all(map(_is_number, kinds)):
        return None
    return VECTOR if VECTOR in kinds else types.float64


def _choose_where(condition, chosen, other):
    value = _shared(chosen, other)
    if value is None or not _is_truth(condition):
        return None
    if condition is MASK:
        return signature(VECTOR, MASK, VECTOR, VECTOR)
    return signature(value, types.boolean, value, value)


define(
    plain.where,
    _choose_where,
    lambda c, b, s, a: b.select(_truth(b, a[0]), a[1], a[2]),
    (MaskType, VectorType, VectorType),
    (types.Boolean, VectorType, VectorType),
    (types.Boolean, types.Float, types.Float),
)


def _elementary(function, emit, arity=1):
    """A function of numbers, or of a vector and numbers."""

    def choose(*kinds):
        value = _shared(*kinds) if len(kinds) == arity else None
        return None if value is None else signature(value, *(value,) * arity)

    define(function, choose, lambda c, b, s, a: emit(b, *a), (VectorType,) * arity, (types.Float,) * arity)


def _call(builder, name, result, *values):
    """Call a function of LLVM."""
    kind = ir.FunctionType(result, [value.type for value in values])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), values)


def _intrinsic(name):
    def emit(builder, value):
        suffix = "v8f64" if isinstance(value.type, ir.VectorType) else "f64"
        return _call(builder, f"{name}.{suffix}", value.type, value)

    return emit


def _integers(kind):
    """The integers of the same width as numbers of a type."""
    return LONGS if isinstance(kind, ir.VectorType) else ir.IntType(64)


def _constant(kind, value):
    """A number of a type, in each lane where it is a vector."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [ir.Constant(kind.element, value)] * LANES)
    return ir.Constant(kind, value)


_MANTISSA, _HALF, _BIAS = (1 << 52) - 1, 1022 << 52, 1022


def _emit_fraction(builder, value):
    whole = _integers(value.type)
    bits = builder.and_(builder.bitcast(value, whole), _constant(whole, _MANTISSA))
    return builder.bitcast(builder.or_(bits, _constant(whole, _HALF)), value.type)


def _emit_exponent(builder, value):
    whole = _integers(value.type)
    shifted = builder.lshr(builder.bitcast(value, whole), _constant(whole, 52))
    return builder.sitofp(builder.sub(shifted, _constant(whole, _BIAS)), value.type)


def _emit_power_of_two(builder, value):
    whole = _integers(value.type)
    number = builder.add(builder.fptosi(value, whole), _constant(whole, _BIAS + 1))
    return builder.bitcast(builder.shl(number, _constant(whole, 52)), value.type)


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


def _emit_finite(context, builder, sig, arguments):
    """|value| < infinity, false for NaN."""
    size = _intrinsic("llvm.fabs")(builder, arguments[0])
    return builder.fcmp_ordered("<", size, _constant(size.type, float("inf")))


def _emit_anywhere(context, builder, sig, arguments):
    if sig.args[0] is not MASK:
        return arguments[0]
    bits = builder.bitcast(arguments[0], ir.IntType(LANES))
    return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))


def _emit_counted(context, builder, sig, arguments):
    bits = builder.bitcast(arguments[0], ir.IntType(LANES))
    return builder.zext(builder.ctpop(bits), ir.IntType(64))


def _emit_first_lanes(context, builder, sig, arguments):
    numbers = ir.Constant(LONGS, [ir.Constant(ir.IntType(64), lane) for lane in range(LANES)])
    return builder.icmp_signed("<", numbers, _splat(builder, arguments[0], LONGS))


define(
    plain.finite,
    lambda kind: signature(MASK if kind is VECTOR else types.boolean, _shared(kind)) if _is_number(kind) else None,
    _emit_finite,
    (VectorType,),
    (types.Float,),
)
define(
    plain.anywhere,
    lambda kind: signature(types.boolean, kind) if _is_truth(kind) else None,
    _emit_anywhere,
    (MaskType,),
    (types.Boolean,),
)
define(plain.counted, lambda kind: signature(types.int64, MASK) if kind is MASK else None, _emit_counted, (MaskType,))
define(
    plain.first_lanes,
    lambda kind: signature(MASK, types.int64) if isinstance(kind, types.Integer) else None,
    _emit_first_lanes,
    (types.Integer,),
)


# To and from arrays ---------------------------------------------------------------------------------------------------


def _is_array(kind, dimensions):
    """Whether a type is that of a contiguous array of so many dimensions, bare or not."""
    whole = isinstance(kind, BareType) or (isinstance(kind, types.Array) and kind.layout == "C")
    return whole and kind.ndim == dimensions


def _parts(context, builder, kind, array):
    """Where the numbers of an array stand, and how many a row has."""
    if isinstance(kind, BareType):
        proxy = cgutils.create_struct_proxy(kind)(context, builder, value=array)
        return proxy.data, proxy.columns
    made = context.make_array(kind)(context, builder, array)
    return made.data, cgutils.unpack_tuple(builder, made.shape)[-1]


def _emit_bare(context, builder, sig, arguments):
    made = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    made.data, made.columns = _parts(context, builder, sig.args[0], arguments[0])
    return made._getvalue()


define(
    plain.bare,
    lambda kind: signature(BareType(kind.dtype, kind.ndim), kind) if _is_array(kind, kind.ndim) else None,
    _emit_bare,
    (types.Array,),
)


def _places(function, dimensions, indices, result, *others):
    """Define a function of a place in an array of one dimension, or two, and of ``others``; ``result`` None: a number.

    One index of a table of two dimensions is that of a line of eight numbers. Negative places do not wrap round. The
    decorated emitter takes the builder, the address of the place, and the values of the others.
    """
    kinds = (*(types.int64,) * indices, *others)

    def choose(array, *rest):
        if _is_array(array, dimensions):
            return signature(array.dtype if result is None else result, array, *kinds)
        return None

    def register(emit):
        def emit_at(context, builder, sig, arguments):
            data, columns = _parts(context, builder, sig.args[0], arguments[0])
            place = arguments[indices]
            if indices == 2:
                place = builder.add(builder.mul(arguments[1], columns), place)
            elif dimensions == 2:
                place = builder.mul(place, ir.Constant(ir.IntType(64), LANES))
            value = emit(builder, builder.gep(data, [place]), *arguments[1 + indices :])
            return context.get_dummy_value() if result is types.none else value

        given = tuple(map(type, kinds))
        define(function, choose, emit_at, (types.Array, *given), (BareType, *given))
        return emit

    return register


def _eight(builder, address, kind=DOUBLES):
    """The address of eight neighbours from a place on."""
    return builder.bitcast(address, kind.as_pointer())


@_places(plain.load, 2, 2, VECTOR, MASK)
def _emit_load(builder, address, lanes):
    zeros = _constant(DOUBLES, 0.0)
    return _call(builder, "llvm.masked.load.v8f64.p0", DOUBLES, _eight(builder, address), ALIGNED, lanes, zeros)


@_places(plain.store, 2, 2, types.none, VECTOR, MASK)
def _emit_store(builder, address, values, lanes):
    place = _eight(builder, address)
    _call(builder, "llvm.masked.store.v8f64.p0", ir.VoidType(), values, place, ALIGNED, lanes)


@_places(plain.store_whole, 1, 1, types.none, VECTOR)
def _emit_store_whole(builder, address, values):
    builder.store(builder.fptosi(values, LONGS), _eight(builder, address, LONGS), align=8)


@_places(plain.mark, 1, 1, types.none)
def _emit_mark(builder, address):
    builder.store(ir.Constant(address.type.pointee, 1), address)


@_places(plain.line, 2, 1, VECTOR)
def _emit_line(builder, address):
    return builder.load(_eight(builder, address), align=8)


@_places(plain.set_line, 2, 1, types.none, VECTOR)
def _emit_set_line(builder, address, values):
    builder.store(values, _eight(builder, address), align=8)


_places(plain.element, 1, 1, None)(ir.IRBuilder.load)
_places(plain.number, 2, 2, None)(ir.IRBuilder.load)


# Lanes ----------------------------------------------------------------------------------------------------------------


def _shuffled(builder, value, other, places):
    mask = ir.Constant(INDICES, [ir.Constant(ir.IntType(32), place) for place in places])
    return builder.shuffle_vector(value, other, mask)


def _emit_transposed(context, builder, sig, rows):
    """Three rounds of exchanges between rows that are 1, 2 and 4 apart."""
    rows = list(rows)
    for apart in (1, 2, 4):
        low = [lane if not lane & apart else lane - apart + LANES for lane in range(LANES)]
        high = [lane + apart if not lane & apart else lane + LANES for lane in range(LANES)]
        for row in (lane for lane in range(LANES) if not lane & apart):
            first, second = rows[row], rows[row + apart]
            rows[row] = _shuffled(builder, first, second, low)
            rows[row + apart] = _shuffled(builder, first, second, high)
    return context.make_tuple(builder, sig.return_type, rows)


def _reduction(function, combine):
    """Reduce by halves, so that the order does not depend on the machine."""

    def emit(context, builder, sig, arguments):
        (value,) = arguments
        for apart in (4, 2, 1):
            other = _shuffled(builder, value, value, [(lane + apart) % LANES for lane in range(LANES)])
            value = combine(builder, value, other)
        return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

    _of_vectors(function, types.float64, emit)


def _of_vectors(function, result, emit, arity=1):
    """Define a function of vectors, or of numbers that are spread."""
    define(
        function,
        lambda *kinds: signature(result, *(VECTOR,) * arity) if all(map(_is_number, kinds)) else None,
        emit,
        (VectorType,) * arity,
    )


_of_vectors(plain.spread, VECTOR, lambda c, b, s, values: values[0])
_of_vectors(plain.transposed, UniTuple(VECTOR, LANES), _emit_transposed, LANES)
_reduction(plain.largest, lambda builder, x, y: _call(builder, "llvm.maxnum.v8f64", DOUBLES, x, y))
_reduction(plain.total, ir.IRBuilder.fadd)
