"""What must not change, and by how little it does: scale, place, frame, mirror, threads, restarts."""

from collections.abc import Iterator

from tests.claims import Row, claim
from tests.claims.proven._rows import case


@claim("similarity", says="geometric similarity holds bit for bit", quick=True)
def similarity() -> Iterator[Row]:
    return case("similarity")


@claim("grid-shift", says="a shift by whole cells changes round-off only", quick=True)
def grid_shift() -> Iterator[Row]:
    return case("grid-shift")


@claim("mirror", says="mirror image and quarter against whole: round-off for 50 steps", quick=True)
def mirror() -> Iterator[Row]:
    return case("mirror")


@claim(
    "quarter-hole",
    says="the hole of a quarter model is that of the whole plate within a twentieth of a cell",
)
def quarter_hole() -> Iterator[Row]:
    return case("quarter-hole")


@claim("bits", says="threads and restarts change no bit, for every shape, scheme and geometry")
def bits() -> Iterator[Row]:
    return case("bits")


@claim("patch", says="uniform states pass the patch tests", quick=True)
def patch() -> Iterator[Row]:
    return case("patch")


@claim("rotation", says="rigid rotation turns stress and keeps its size", quick=True)
def rotation() -> Iterator[Row]:
    return case("rotation")


@claim(
    "johnson-cook",
    says="a point follows Johnson and Cook's yield stress, cold to molten",
    quick=True,
)
def johnson_cook() -> Iterator[Row]:
    return case("johnson-cook")


@claim(
    "steinberg-guinan",
    says="a point follows Steinberg, Cochran and Guinan's modulus, yield stress and melting curve",
    quick=True,
)
def steinberg_guinan() -> Iterator[Row]:
    return case("steinberg-guinan")


@claim(
    "absorbing",
    says="plane longitudinal waves leave through absorbing surfaces but for 0.1 % of their energy, and all is booked",
    quick=True,
)
def absorbing() -> Iterator[Row]:
    return case("absorbing")


@claim(
    "absorbing-block",
    says="the crater of copper at 6 km/s in a block that absorbs is that in one half as large again to 1 %",
)
def absorbing_block() -> Iterator[Row]:
    return case("absorbing-block")


@claim("momentum", says="axial momentum of an impact stays to 1e-10 until a fixed face is reached")
def momentum() -> Iterator[Row]:
    return case("momentum")


@claim("energy", says="energy of impacts is kept within 1 %; what the audit cannot see is reported")
def energy() -> Iterator[Row]:
    return case("energy")
