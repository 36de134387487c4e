"""Vectors inside kernels: to and from arrays, lines of nodes, and what eight numbers add up to."""

from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core.typing.templates import signature

from solver import vectors as plain
from solver.vectors import LANES
from solver.vectors.compiled import (
    BITS,
    DOUBLES,
    INDICES,
    LONGS,
    MASK,
    VECTOR,
    BareType,
    MaskType,
    VectorType,
    constant,
    define,
    external,
    is_number,
    types,
)


def _address(context: Any, builder: Any, kind: Any, table: Any, row: Any, place: Any) -> Any:
    """Where table[row, place] stands; rows are contiguous. No wrapping round of negative numbers."""
    data, columns = _parts(context, builder, kind, table)
    if kind.ndim == 2:
        place = builder.add(builder.mul(row, columns), place)
    return builder.gep(data, [place])


def _parts(context: Any, builder: Any, kind: Any, array: Any) -> tuple[Any, Any]:
    """Where the numbers of an array stand, and how many a row has."""
    if isinstance(kind, BareType):
        proxy = cgutils.create_struct_proxy(kind)(context, builder, value=array)
        return proxy.data, proxy.columns
    made = context.make_array(kind)(context, builder, array)
    return made.data, cgutils.unpack_tuple(builder, made.shape)[-1]


def define_on_arrays(function: Any, choose: Any, emit: Any, *kinds: Any) -> None:
    """Define a function whose first argument is an array, bare or not."""
    define(function, choose, emit, (types.Array, *kinds), (BareType, *kinds))


def _is_row(kind: Any) -> bool:
    return isinstance(kind, BareType) or (isinstance(kind, types.Array) and kind.layout == "C")


def _is_table(kind: Any) -> bool:
    return _is_row(kind) and kind.ndim == 2


def _emit_bare(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    made = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    made.data, made.columns = _parts(context, builder, sig.args[0], arguments[0])
    return made._getvalue()


define(
    plain.bare,
    lambda kind: signature(BareType(kind.dtype, kind.ndim), kind) if _is_row(kind) else None,
    _emit_bare,
    (types.Array,),
)


def _emit_load(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, place, lanes = arguments
    address = _address(context, builder, sig.args[0], table, row, place)
    address = builder.bitcast(address, DOUBLES.as_pointer())
    kinds = [address.type, ir.IntType(32), BITS, DOUBLES]
    function = external(builder, "llvm.masked.load.v8f64.p0", kinds, DOUBLES)
    zeros = constant(DOUBLES, 0.0)
    return builder.call(function, [address, ir.Constant(ir.IntType(32), 8), lanes, zeros])


def _emit_store(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, place, values, lanes = arguments
    address = _address(context, builder, sig.args[0], table, row, place)
    address = builder.bitcast(address, DOUBLES.as_pointer())
    kinds = [DOUBLES, address.type, ir.IntType(32), BITS]
    function = external(builder, "llvm.masked.store.v8f64.p0", kinds, ir.VoidType())
    builder.call(function, [values, address, ir.Constant(ir.IntType(32), 8), lanes])
    return context.get_dummy_value()


define_on_arrays(
    plain.load,
    lambda table, row, place, lanes: (
        signature(VECTOR, table, types.int64, types.int64, MASK) if _is_table(table) else None
    ),
    _emit_load,
    types.Integer,
    types.Integer,
    MaskType,
)
define_on_arrays(
    plain.store,
    lambda table, row, place, values, lanes: (
        signature(types.none, table, types.int64, types.int64, VECTOR, MASK)
        if _is_table(table) and is_number(values)
        else None
    ),
    _emit_store,
    types.Integer,
    types.Integer,
    VectorType,
    MaskType,
)


def _emit_store_whole(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    places, place, values = arguments
    address = _address(context, builder, sig.args[0], places, None, place)
    address = builder.bitcast(address, LONGS.as_pointer())
    builder.store(builder.fptosi(values, LONGS), address, align=8)
    return context.get_dummy_value()


define_on_arrays(
    plain.store_whole,
    lambda places, place, values: signature(types.none, places, types.int64, VECTOR),
    _emit_store_whole,
    types.Integer,
    VectorType,
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


define_on_arrays(
    plain.element,
    lambda array, place: signature(array.dtype, array, types.int64) if _is_row(array) else None,
    _emit_element,
    types.Integer,
)
define_on_arrays(
    plain.mark,
    lambda flags, place: signature(types.none, flags, types.int64) if _is_row(flags) else None,
    _emit_mark,
    types.Integer,
)
define_on_arrays(
    plain.number,
    lambda table, row, place: signature(types.float64, table, types.int64, types.int64) if _is_table(table) else None,
    _emit_number,
    types.Integer,
    types.Integer,
)


def _line_address(context: Any, builder: Any, kind: Any, table: Any, row: Any) -> Any:
    data, _ = _parts(context, builder, kind, table)
    place = builder.mul(row, ir.Constant(ir.IntType(64), LANES))
    return builder.bitcast(builder.gep(data, [place]), DOUBLES.as_pointer())


def _emit_line(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return builder.load(_line_address(context, builder, sig.args[0], *arguments), align=8)


def _emit_set_line(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    table, row, values = arguments
    builder.store(values, _line_address(context, builder, sig.args[0], table, row), align=8)
    return context.get_dummy_value()


define_on_arrays(
    plain.line,
    lambda table, row: signature(VECTOR, table, types.int64) if _is_table(table) else None,
    _emit_line,
    types.Integer,
)
define_on_arrays(
    plain.set_line,
    lambda table, row, values: signature(types.none, table, types.int64, VECTOR) if _is_table(table) else None,
    _emit_set_line,
    types.Integer,
    VectorType,
)


def _shuffled(builder: Any, value: Any, other: Any, places: Any) -> Any:
    mask = ir.Constant(INDICES, [ir.Constant(ir.IntType(32), place) for place in places])
    return builder.shuffle_vector(value, other, mask)


def _emit_transposed(context: Any, builder: Any, sig: Any, rows: Any) -> Any:
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


define(
    plain.transposed,
    lambda *rows: signature(types.UniTuple(VECTOR, LANES), *(VECTOR,) * LANES) if all(map(is_number, rows)) else None,
    _emit_transposed,
    (VectorType,) * LANES,
)


def _reduction(function: Any, combine: Any) -> None:
    """Reduce by halves, so that the order does not depend on the machine."""

    def emit(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        (value,) = arguments
        for apart in (4, 2, 1):
            other = _shuffled(builder, value, value, [(lane + apart) % LANES for lane in range(LANES)])
            value = combine(builder, value, other)
        return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

    define(function, lambda kind: signature(types.float64, VECTOR) if is_number(kind) else None, emit, (VectorType,))


def _larger(builder: Any, value: Any, other: Any) -> Any:
    function = external(builder, "llvm.maxnum.v8f64", [DOUBLES, DOUBLES], DOUBLES)
    return builder.call(function, [value, other])


_reduction(plain.largest, _larger)
_reduction(plain.total, lambda b, x, y: b.fadd(x, y))
