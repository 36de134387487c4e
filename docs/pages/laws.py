"""laws.md: formula, range, source and plot of every law that ships, from ``studies/laws``."""

import importlib
import math
import pkgutil
from collections.abc import Iterator, Mapping
from functools import partial

from docs.pages import plots
from solver.registry import folders
from studies import laws, materials, measurements
from studies.laws import NOT_FOUND, Law, Limit, Shot, limit_in_latex
from studies.materials.schema import CONFIDENCES

SPEEDS = [2e3 + 100.0 * step for step in range(61)]  # m/s
DIAMETER = 8e-3  # m
THICKNESS = 0.25  # over the diameter, of the plotted holes
METALS = {"copper-ofhc": "copper on copper", "al-6061-t6": "aluminium on aluminium"}
ALUMINIUM = {"al-6061-t6": METALS["al-6061-t6"]}
PLATE = 4.4e-3  # m, of 6061-T6: Fig. 4-4 of the handbook
SHIELD_SPEEDS = [1e3 + 100.0 * step for step in range(131)]
MOST_LINES = 7  # laws of one plot; of more, those are drawn that have a point inside their range


def pages() -> dict[str, str]:
    """laws.md."""
    parts = [
        "# Laws\n",
        "Published formulas that a report compares with the simulation. `D` is the diameter of a hole, `p` the depth "
        "of a crater from the original surface, `d` the diameter of the sphere with the projectile's volume, `t` the "
        "thickness of the plate, `v` the impact speed. A law outside its range still answers, and is flagged; where "
        "its formula means nothing, it has no value. In brackets behind a limit stands its source, where that is not "
        "the law's, and `not checked` where a shot does not tell whether it is met.\n",
    ]
    for quantity in quantities():
        title = title_of(quantity)
        parts += [f"## {title}\n"]
        over = "" if _is_critical(quantity) else f" over {_norm(quantity)}"
        parts += [f"![{title}{over} against speed, by each law](drawings/laws-{quantity}.svg)\n"]
        parts += [_caption(quantity)]
        for law in laws.answering(quantity):
            parts += list(_section(law))
    parts += ["How to add a law: [how-to](how-to.md#a-law-of-your-own)."]
    return {"laws.md": "\n".join(parts) + "\n"}


def quantities() -> list[str]:
    """The quantities that a law answers: those that are measured, holes first, and then the others."""
    answered = {laws.load(name).quantity for name in laws.names()}
    measured = sorted(answered - set(laws.unmeasured()), reverse=True)
    return [*measured, *(name for name in laws.unmeasured() if name in answered)]


def title_of(quantity: str) -> str:
    """The title of a quantity, measured or not."""
    return laws.unmeasured().get(quantity) or measurements.load(quantity).title


def _is_critical(quantity: str) -> bool:
    """Whether it is a diameter of the projectile, which is drawn in mm."""
    return quantity.endswith("critical_diameter")


def _norm(quantity: str) -> str:
    cube = laws.answering(quantity)[0].dimension == 3
    return "cube of the projectile diameter" if cube else "projectile diameter"


def _caption(quantity: str) -> str:
    lines = "full lines are inside the range of the law, dotted ones outside"
    if quantity == "plate_critical_diameter":
        text = f"A plate of {1e3 * PLATE:g} mm of aluminium 6061-T6, that of Fig. 4-4 of NASA/TM-2009-214785; {lines}."
    elif quantity == "critical_diameter":
        shield = "The shield of Fig. 4-4 of NASA/TM-2009-214785: bumper of 1.2 mm, 100 mm before a wall"
        text = f"{shield} of 3.2 mm, both of aluminium 6061-T6, at normal impact; {lines}."
    else:
        plate = f" t/d = {THICKNESS:g};" if "hole" in quantity else ""
        text = f"Spheres of {1e3 * DIAMETER:g} mm;{plate} {lines}; a law with several published constants has a line "
        text += "for each."
    if quantity in laws.unmeasured():
        text += " No run measures this, so that no report compares it."
    drawn = {law.title for law in drawn_laws(quantity)}
    undrawn = [law.title for law in laws.answering(quantity) if law.title not in drawn]
    if undrawn:
        text += f" Not drawn, because outside of their range: {', '.join(undrawn)}."
    return text + "\n"


def drawn_laws(quantity: str) -> list[Law]:
    """The laws of a plot: all that have a value, or of many those that are inside their range somewhere in it."""
    plotted = [shot for name in _panels(quantity) for shot in _shots(quantity, name)]
    answering = [
        law
        for law in laws.answering(quantity)
        if any(math.isfinite(law.evaluate(shot, law.variants(shot)[0]).value) for shot in plotted)
    ]
    if len(answering) <= MOST_LINES:
        return answering
    return [law for law in answering if any(law.evaluate(shot, law.variants(shot)[0]).in_range for shot in plotted)]


def _section(law: Law) -> Iterator[str]:
    yield f"### {law.title}\n"
    yield f"`{law.name}`, `{file_of(law)}`\n"
    yield f"{law.latex or law.equation}\n"
    scatter = "not published" if law.scatter is None else f"{100.0 * law.scatter:.0f} %"
    known = CONFIDENCES.get(law.confidence, law.confidence)
    use = "" if law.use == "verdict" else f" Use: {law.use}."
    yield f"Source: {law.source}. Equation: {known}.{use} Published scatter: {scatter}.\n"
    yield f"Range: {'; '.join(map(partial(_limit, law), law.range.every))}.\n"


def _limit(law: Law, limit: Limit) -> str:
    """A limit, with its source where that is another one than the law's."""
    derived = not limit.is_published and limit.source != NOT_FOUND
    notes = [
        *([] if derived or limit.source in law.source else [limit.source]),
        *([] if limit.machine_checked else ["not checked"]),
    ]
    return limit_in_latex(limit) + (f" ({', '.join(notes)})" if notes else "")


def file_of(law: Law) -> str:
    """The file that offers a law, alone or among others."""
    for folder in folders(laws.__name__):
        for found in pkgutil.iter_modules(folder.__path__):
            offered = getattr(importlib.import_module(f"{folder.__name__}.{found.name}"), "LAW", ())
            if law in (offered if isinstance(offered, tuple) else (offered,)):
                return f"{folder.__name__.replace('.', '/')}/{found.name}.py"
    return "another distribution"


def drawings() -> dict[str, str]:
    """A plot for each quantity: a panel for each metal, a line for each law and each of its variants."""
    return {f"laws-{quantity}.svg": _drawing(quantity) for quantity in quantities()}


def _panels(quantity: str) -> Mapping[str, str]:
    """Material and title of each panel."""
    plates = ("thickness", "critical_diameter")
    return ALUMINIUM if quantity.endswith(plates) else METALS


def _shots(quantity: str, name: str) -> list[Shot]:
    """The shots of a panel, in the order of their speeds."""
    material = materials.load(name)
    plates = {"hole": THICKNESS * DIAMETER, "plate_critical_diameter": PLATE}
    shots = [
        Shot(
            speed=speed,
            projectile_diameter=DIAMETER,
            plate_thickness=next((plate for words, plate in plates.items() if words in quantity), None),
            projectile=material,
            target=material,
        )
        for speed in (SHIELD_SPEEDS if _is_critical(quantity) else SPEEDS)
    ]
    if quantity != "critical_diameter":
        return shots
    from docs.pages.shields import at_plotted_shield  # which may be taken away

    return list(map(at_plotted_shield, shots))


def _drawing(quantity: str) -> str:
    critical = _is_critical(quantity)
    panels = []
    for name, title in _panels(quantity).items():
        shots = _shots(quantity, name)
        lines = []
        for law in drawn_laws(quantity):
            for variant in law.variants(shots[0]):
                answers = [(shot, law.evaluate(shot, variant)) for shot in shots]
                points = [
                    (shot.speed / 1e3, answer.value / (1e-3 if critical else DIAMETER**law.dimension), answer.in_range)
                    for shot, answer in answers
                ]
                lines.append((law.title, points))
        panels.append((title, lines))
    label = "critical diameter (mm)" if critical else f"over {_norm(quantity)}"
    return plots.curves(panels, xlabel="speed (km/s)", ylabel=label)
