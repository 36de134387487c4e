"""docs/laws.md: formula, range, source and plot of every law that ships, from ``studies/laws``."""

from collections.abc import Iterator

from docs.pages import MADE, plots, table
from studies import laws, materials, measurements
from studies.laws import Law, Shot
from studies.materials.schema import CONFIDENCES

SPEEDS = [2e3 + 100.0 * step for step in range(61)]  # m/s
DIAMETER = 8e-3  # m
THICKNESS = 0.25  # over the diameter, of the plotted holes
METALS = {"copper-ofhc": "copper on copper", "al-6061-t6": "aluminium on aluminium"}


def page() -> str:
    """docs/laws.md."""
    parts = [
        "# Laws\n",
        MADE.format(source="`studies/laws/`"),
        "Published formulas that a report compares with the simulation. `D` is the diameter of a hole, `p` the depth "
        "of a crater from the original surface, `d` the diameter of the sphere with the projectile's volume, `t` the "
        "thickness of the plate, `v` the impact speed. A law outside its range still answers, and is flagged; where "
        "its formula means nothing, it has no value.\n",
    ]
    for quantity in quantities():
        title = measurements.load(quantity).title
        parts += [f"## {title}\n"]
        parts += [
            f"![{title} over projectile diameter against speed, by each law](drawings/laws-{quantity}.svg)\n"
        ]
        parts += [_caption(quantity)]
        for law in laws.answering(quantity):
            parts += list(_section(law))
    parts += ["How to add a law: [how-to](how-to.md#a-law-of-your-own)."]
    return "\n".join(parts) + "\n"


def quantities() -> list[str]:
    """The measured quantities that a law answers, holes first."""
    return sorted({laws.load(name).quantity for name in laws.names()}, reverse=True)


def _caption(quantity: str) -> str:
    plate = f" t/d = {THICKNESS:g};" if "hole" in quantity else ""
    spheres = f"Spheres of {1e3 * DIAMETER:g} mm;{plate}"
    lines = "full lines are inside the range of the law, dotted ones outside"
    return f"{spheres} {lines}; a law with a yield stress has a line for each published one.\n"


def _section(law: Law) -> Iterator[str]:
    yield f"### {law.title}\n"
    yield f"`{law.name}`, `studies/laws/{law.name}.py`\n"
    yield f"```text\n{law.equation}\n```\n"
    scatter = "not published" if law.scatter is None else f"{100.0 * law.scatter:.0f} %"
    known = CONFIDENCES.get(law.confidence, law.confidence)
    yield f"Source: {law.source}. Equation: {known}. Published scatter: {scatter}.\n"
    yield table(
        ["range", "source of the limit", "checked for each shot"],
        [
            [limit.words, limit.source, "yes" if limit.machine_checked else "no"]
            for limit in law.range.every
        ],
    )


def drawings() -> dict[str, str]:
    """A plot for each quantity: a panel for each metal, a line for each law and each of its variants."""
    return {f"laws-{quantity}.svg": _drawing(quantity) for quantity in quantities()}


def _drawing(quantity: str) -> str:
    panels = []
    for name, title in METALS.items():
        material = materials.load(name)
        shots = [
            Shot(
                speed=speed,
                projectile_diameter=DIAMETER,
                plate_thickness=THICKNESS * DIAMETER if "hole" in quantity else None,
                projectile=material,
                target=material,
            )
            for speed in SPEEDS
        ]
        lines = []
        for law in laws.answering(quantity):
            for variant in law.variants(shots[0]):
                answers = [law.evaluate(shot, variant) for shot in shots]
                points = [
                    (speed / 1e3, answer.value / DIAMETER, answer.in_range)
                    for speed, answer in zip(SPEEDS, answers, strict=True)
                ]
                lines.append((law.title, points))
        panels.append((title, lines))
    return plots.curves(panels, xlabel="speed (km/s)", ylabel="over projectile diameter")
