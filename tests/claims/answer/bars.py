"""Error bars of grids: synthetic series of known limit."""

from collections.abc import Iterator

from tests.claims import Row, at_least, at_most, claim
from tests.studies.convergence.series import LAYOUTS, widths

SERIES = 1000  # of each kind
COVERED, WIDEST = 0.94, 3.0


@claim(
    "bars",
    says="error bars of three grids hold the limit of at least 94 % of synthetic series (monotone of order 1 to 2, "
    "steeper than 3, within the scatter of the offsets, noisy, with the coarsest grid outside the asymptotic range), "
    "and their median is at most three times the root mean square of the true errors",
)
def bars() -> Iterator[Row]:
    for spacings, offsets in LAYOUTS:
        for width in widths(spacings, offsets, SERIES):
            cells = ", ".join(f"{spacing:.3g}" for spacing in spacings)
            name = f"{width.kind}, cells of {cells}, offsets {offsets}"
            if width.kind == "all":
                yield at_least(f"{name}: share covered", limit=COVERED, got=width.covered)
                wide = width.bar / width.error
                yield at_most(f"{name}: median bar over rms error", limit=WIDEST, got=wide)
            text = f"{width.covered:.1%} covered, median of bar over error {width.ratio:.1f}"
            yield Row(name, "", text, None)
