"""The catalogue that ships: materials, laws and scenarios; no service is needed."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from service.cli.commands import SHIPPED, Commands
from service.cli.commands.answering import print_answers
from service.cli.console import print_json, print_table
from service.cli.options import Json
from studies.quantities.findings import refusal
from studies.quantities.parameters import Parameter, declared
from studies.quantities.units import readable

if TYPE_CHECKING:
    from studies.laws import Law
    from studies.materials import Material
    from studies.scenarios import Scenario

app = typer.Typer()
COMMANDS = Commands("catalogue", SHIPPED, app)


@app.command("list")
def list_kind(
    kind: Annotated[
        Literal["materials", "laws", "scenarios"], typer.Argument(metavar="KIND", help="materials, laws or scenarios.")
    ],
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Show this one in full.")] = None,
    as_json: Json = False,
) -> None:
    """List the materials, the published laws or the scenarios, or show one with units and sources."""
    from studies import laws, materials, scenarios

    if as_json:
        if kind == "materials":
            documents = [materials.load(entry).document() for entry in ([name] if name else materials.names())]
        else:
            shipped = laws if kind == "laws" else scenarios
            documents = [shipped.load(entry).describe() for entry in ([name] if name else shipped.names())]
        print_json(documents[0] if name else documents)
    elif kind == "materials":
        _show_material(materials.load(name)) if name else _list_materials(map(materials.load, materials.names()))
    elif kind == "laws":
        _show_law(laws.load(name)) if name else _list_laws(map(laws.load, laws.names()))
    else:
        _show_scenario(scenarios.load(name)) if name else _list_scenarios(map(scenarios.load, scenarios.names()))


def _list_materials(listed: "Iterable[Material]") -> None:
    rows = (
        (
            *(metal.name, metal.title, metal.family, _value(metal.density, metal.sources["density"].unit)),
            *(metal.eos.kind, metal.strength.kind),
        )
        for metal in listed
    )
    print_table(("name", "title", "family", "density", "equation of state", "strength"), rows)


def _show_material(material: "Material") -> None:
    print(f"{material.name}: {material.title} ({material.family}; {material.eos.kind}, {material.strength.kind})")
    stated = sorted(material.sources.items(), key=lambda item: item[0].startswith("yield_stresses."))
    rows = (
        (path.replace("yield_stresses.", "yield stress: "), _value(c.value, c.unit), c.confidence, c.source)
        for path, c in stated
    )
    print_table(("constant", "value", "confidence", "source"), rows)


def _list_laws(listed: "Iterable[Law]") -> None:
    rows = ((law.name, law.title, law.quantity, law.use.partition(" (")[0]) for law in listed)
    print_table(("name", "title", "quantity", "use"), rows)


def _show_law(law: "Law") -> None:
    from studies.laws import limit_in_words

    print(f"{law.name}: {law.title}, for {law.quantity}")
    print(f"  equation  {law.equation}")
    print(f"  source    {law.source} ({law.confidence})")
    print(f"  use       {law.use}")
    scatter = "not published" if law.scatter is None else f"{law.scatter:.0%} (relative standard deviation)"
    print(f"  scatter   {scatter}")
    rows = (
        (limit_in_words(limit), limit.source, "yes" if limit.machine_checked else "no") for limit in law.range.every
    )
    print_table(("range", "source of the limit", "checked"), rows)


def _list_scenarios(listed: "Iterable[Scenario]") -> None:
    print_table(("name", "title", "measures"), ((s.name, s.title, ", ".join(s.measurements)) for s in listed))


def _show_scenario(scenario: "Scenario") -> None:
    print(f"{scenario.name}: {scenario.title}\n{scenario.description}")
    print(f"measures: {', '.join(scenario.measurements)}")
    parameters = declared(scenario.parameters).values()
    rows = ((p.name, _default(p), p.limit(), p.meaning) for p in parameters)
    print_table(("parameter", "default", "allowed", "meaning"), rows)


def _default(parameter: Parameter) -> str:
    if parameter.required:
        return "required"
    return "" if parameter.default is None else _value(parameter.default, parameter.unit)


def _value(value: float | str | None, unit: str | None) -> str:
    """A value with its unit, as a sweep document writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "none"
    return readable(value, unit) if unit and not isinstance(value, str) else str(value)


# --- the laws about a shot ------------------------------------------------------------------------


def _quantity(flag: str, words: str) -> typer.models.OptionInfo:
    option: typer.models.OptionInfo = typer.Option(flag, metavar="QUANTITY", help=words)
    return option


@app.command("laws")
def laws_about(
    at: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Ask every law about the shots of a file (YAML or JSON).")
    ] = None,
    speed: Annotated[str | None, _quantity("--speed", "Ask about a shot at this speed: 6 km/s.")] = None,
    projectile: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Material of the projectile.")] = None,
    projectile_diameter: Annotated[str | None, _quantity("--diameter", "Diameter of the projectile: 5 mm.")] = None,
    projectile_length: Annotated[str | None, _quantity("--length", "Length of a cylinder; none: a sphere.")] = None,
    target: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Material of a plate or a block.")] = None,
    plate_thickness: Annotated[str | None, _quantity("--thickness", "Of a plate; none: a block.")] = None,
    bumper: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Bumper of a shield.")] = None,
    bumper_thickness: Annotated[str | None, _quantity("--bumper-thickness", "Of a shield's bumper.")] = None,
    stand_off: Annotated[str | None, _quantity("--stand-off", "Between bumper and wall of a shield: 10 cm.")] = None,
    wall_thickness: Annotated[str | None, _quantity("--wall-thickness", "Thickness of a shield's wall.")] = None,
    wall: Annotated[str | None, typer.Option(metavar="MATERIAL", help="A shield's wall; none: as its bumper.")] = None,
    obliquity: Annotated[str | None, _quantity("--obliquity", "Angle from the target's normal: 45 deg.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the answer: .html, .svg, .png or .pdf, or laws.nc of many shots.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Ask all published laws about a shot: --at FILE, or --speed, --projectile, ..."""
    asked = {
        **{"speed": speed, "projectile": projectile, "projectile_diameter": projectile_diameter},
        **{"projectile_length": projectile_length, "target": target, "plate_thickness": plate_thickness},
        **{"bumper": bumper, "bumper_thickness": bumper_thickness, "stand_off": stand_off},
        **{"wall_thickness": wall_thickness, "wall": wall, "obliquity": obliquity},
    }
    given = {name: value for name, value in asked.items() if value is not None}
    if at is None and not given:
        raise refusal("laws", "no shot", "--at FILE, or --speed, ...", "name a shot; `whipple list laws` lists them")
    print_answers(at, given, out, as_json=as_json)
