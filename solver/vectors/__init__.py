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

``plain.py`` says what each function means, ``elementary.py`` has logarithm, exponential and power, ``compiled.py`` and
``memory.py`` are what kernels are made of.
"""

from solver.jit import when_compiling
from solver.vectors.elementary import SMALLEST, exp, log, power
from solver.vectors.plain import (
    LANES,
    absolute,
    alike,
    anywhere,
    bare,
    counted,
    element,
    exponent,
    finite,
    first_lanes,
    floor,
    fraction,
    largest,
    line,
    load,
    mark,
    maximum,
    minimum,
    nearest,
    number,
    power_of_two,
    set_line,
    spread,
    sqrt,
    store,
    store_whole,
    total,
    transposed,
    where,
)

__all__ = [
    "LANES",
    "SMALLEST",
    "absolute",
    "alike",
    "anywhere",
    "bare",
    "counted",
    "element",
    "exp",
    "exponent",
    "finite",
    "first_lanes",
    "floor",
    "fraction",
    "largest",
    "line",
    "load",
    "log",
    "mark",
    "maximum",
    "minimum",
    "nearest",
    "number",
    "power",
    "power_of_two",
    "set_line",
    "spread",
    "sqrt",
    "store",
    "store_whole",
    "total",
    "transposed",
    "where",
]


@when_compiling
def _register() -> None:
    """Import what registers the code of the functions; it takes numba."""
    import solver.vectors.compiled
    import solver.vectors.memory  # noqa: F401
