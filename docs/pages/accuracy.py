"""docs/accuracy.md: how accurate the solver is, on one page, from the results behind the pages of shots and cases."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from docs.pages import MADE, counted, read_json, shots, table, validation, verification
from studies.quantities.display import NONE, digits

# Quantity and target of the cases that stand in one row; a case that none names has a row of its own.
PUBLISHED = (
    ("hole diameter", "plates of copper and aluminium", ("thesis-holes", "aluminium-holes", "hole-laws")),
    ("crater depth and diameter", "blocks of copper", ("table-3-3", "table-3-4", "shape-coefficient")),
    ("length and diameters of a bar", "copper on a wall", ("taylor-bar",)),
    ("debris: momentum, shape, melt", "plates of copper", ("debris-clouds", "melted-projectile")),
    ("time at the wall, energy", "elastic bar", ("elastic-bar",)),
    ("peak of a free surface; its pull-back is reported", "plates of copper and aluminium", ("plate-spall",)),
)
EXACT = (
    (
        *("pressure, density, speed of shocks", "plates of eight metals, 2 to 6 km/s and beyond"),
        ("plate-impact", "plate-impact-all", "velocity-boost", "release", "sph-plate-impact", "sph-plate-impact-box"),
    ),
    (
        *("strong shocks, detonation", "gases and TNT"),
        ("sod", "noh-plane-axis", "noh-point", "chapman-jouguet", "sph-sod", "sph-noh"),
    ),
    (
        *("elastic waves", "bars, columns, blocks that absorb"),
        (
            *("elastic-waves", "vibrating-bar", "loads", "absorbing", "absorbing-block"),
            *("coupled-bar", "finite-elements", "sph-elastic-waves"),
        ),
    ),
    ("free surface and break of a plate", "aluminium on copper, as fluids", ("spall",)),
    ("contact of bodies", "bars, spheres, walls", ("bar-contact", "contact", "contact-gap")),
    ("energy, momentum", "impacts", ("energy", "momentum")),
    ("stress of a point", "models of materials", ("johnson-cook", "steinberg-guinan", "tillotson", "rotation")),
    (
        *("the same numbers", "threads, restarts, mirror, scale, place"),
        ("bits", "mirror", "similarity", "grid-shift", "quarter-hole"),
    ),
    ("uniform states", "patches", ("patch", "sph-patch")),
)
Rows = Sequence[Mapping[str, Any]]


def pages() -> dict[str, str]:
    """docs/accuracy.md."""
    header = ["quantity", "target", "beside", "how accurate", "tables"]
    sources = ("docs/results/", f"studies/observations/{shots.STORED.name}")
    rows = [*_shots(), *_cases(PUBLISHED, _published(), "published numbers"), *_cases(EXACT, _exact(), "exact answer")]
    text = [
        "# How accurate is it\n",
        MADE.format(source=" and ".join(f"`{source}`" for source in sources)),
        "Bias is the mean of simulation / shot − 1, as an interval of 95 %; scatter its standard deviation. A gate is "
        "a tolerance that was stated before the run; the other rows are reported, among them the values without a "
        "mesh beside published numbers. Differences are relative to the number beside. Your own result has its own "
        "error bar ([how fine is fine enough](../README.md#how-fine-is-fine-enough)).\n",
        table(header, rows),
        "All tables: [shots](shots.md), [published problems](validation.md), [exact answers](verification.md). What no "
        "table covers: [limits](limits.md).\n",
    ]
    return {"accuracy.md": "\n".join(text)}


def _shots() -> Iterator[list[str]]:
    for title, quantity, rows in shots.grouped(shots.stored()["shots"]):
        count, bias, scatter = shots.cells(rows)
        ratios = sorted(ratio for ratio in map(shots.ratio, rows) if not math.isnan(ratio))
        ends = dict.fromkeys(map(shots.percent, ratios[:1] + ratios[-1:]))
        few = f"too few for a bias: {' to '.join(ends)} %"
        result = few if bias == NONE else f"bias {bias} %, scatter {scatter} %"
        anchor = title.lower().replace(",", "").replace(" ", "-")
        yield [quantity.lower(), title, f"{count} of {len(rows)} shots", result, f"[shots](shots.md#{anchor})"]


def _published() -> dict[str, tuple[str, Rows]]:
    """Page and rows of each published problem, on the finest grids."""
    cases = read_json(validation.STORED)["cases"]
    return {name: (f"validation/{name}.md", kept["rows"]) for name, kept in cases.items() if "/" not in name}


def _exact() -> dict[str, tuple[str, Rows]]:
    """Page and rows of each case with an exact answer."""
    return {name: (f"verification/{name}.md", rows) for name, rows in read_json(verification.STORED)["cases"].items()}


def _cases(
    groups: Sequence[tuple[str, str, Sequence[str]]], cases: Mapping[str, tuple[str, Rows]], beside: str
) -> Iterator[list[str]]:
    named = {name for _, _, names in groups for name in names}
    for quantity, target, names in (*groups, *((name, "", (name,)) for name in cases if name not in named)):
        mine = [name for name in names if name in cases]
        rows = [row for name in mine for row in cases[name][1]]
        links = ", ".join(f"[{name}]({cases[name][0]})" for name in mine)
        yield [quantity, target, beside, f"{counted(rows)} gates held{_differences(rows)}", links]


def _differences(rows: Rows) -> str:
    """The largest relative differences from numbers, of gated rows and of reported ones."""
    texts = []
    for word, mine in (
        ("gated", [row for row in rows if row["passed"] is not None]),
        ("reported", [row for row in rows if row["passed"] is None]),
    ):
        pairs = [(row["got"], row["expected"]) for row in mine if row["expected"]]
        ratios = [got / expected for got, expected in pairs if isinstance(got, float) and isinstance(expected, float)]
        if ratios:
            texts.append(f"{word} to {digits(100.0 * max(abs(ratio - 1.0) for ratio in ratios), 2)} %")
    return f"; differences {', '.join(texts)}" if texts else ""
