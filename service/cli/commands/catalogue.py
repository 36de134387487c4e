"""The catalogue that ships: materials, laws and scenarios; no service is needed."""

from collections.abc import Iterable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands import SHIPPED, Commands
from service.cli.console import print_json, print_table
from service.cli.options import Json
from studies.quantities.parameters import Parameter, declared
from studies.quantities.units import readable

if TYPE_CHECKING:
    from studies.laws import Law
    from studies.materials import Material
    from studies.scenarios import Scenario

app = typer.Typer()
COMMANDS = Commands("catalogue", SHIPPED, app)


class Kind(StrEnum):
    """What ships."""

    MATERIALS = "materials"
    LAWS = "laws"
    SCENARIOS = "scenarios"


@app.command("list")
def list_kind(
    kind: Annotated[Kind, typer.Argument(metavar="KIND", help="materials, laws or scenarios.")],
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Show this one in full.")] = None,
    as_json: Json = False,
) -> None:
    """List the materials, the published laws or the scenarios, or show one with units and sources."""
    from studies import laws, materials, scenarios

    if as_json and kind is Kind.MATERIALS:
        documents = {each: materials.load(each).document() for each in ([name] if name else materials.names())}
    elif as_json:
        shipped = laws if kind is Kind.LAWS else scenarios
        documents = {each: shipped.load(each).describe() for each in ([name] if name else shipped.names())}
    if as_json:
        print_json(documents[name] if name else [*documents.values()])
    elif kind is Kind.MATERIALS:
        _show_material(materials.load(name)) if name else _list_materials(map(materials.load, materials.names()))
    elif kind is Kind.LAWS:
        _show_law(laws.load(name)) if name else _list_laws(map(laws.load, laws.names()))
    else:
        _show_scenario(scenarios.load(name)) if name else _list_scenarios(map(scenarios.load, scenarios.names()))


def _list_materials(materials: "Iterable[Material]") -> None:
    rows = (
        (
            *(each.name, each.title, each.family, value_with_unit(each.density, each.sources["density"].unit)),
            *(each.eos.kind, each.strength.kind),
        )
        for each in materials
    )
    print_table(("name", "title", "family", "density", "equation of state", "strength"), rows)


def _show_material(material: "Material") -> None:
    print(f"{material.name}: {material.title} ({material.family}; {material.eos.kind}, {material.strength.kind})")
    stated = sorted(material.sources.items(), key=lambda item: item[0].startswith("yield_stresses."))
    rows = (
        (
            path.replace("yield_stresses.", "yield stress: "),
            value_with_unit(each.value, each.unit),
            each.confidence,
            each.source,
        )
        for path, each in stated
    )
    print_table(("constant", "value", "confidence", "source"), rows)


def _list_laws(laws: "Iterable[Law]") -> None:
    rows = ((law.name, law.title, law.quantity, law.use.partition(" (")[0]) for law in laws)
    print_table(("name", "title", "quantity", "use"), rows)


def _show_law(law: "Law") -> None:
    from studies.laws import limit_in_words

    print(f"{law.name}: {law.title}, for {law.quantity}")
    print(f"  equation  {law.equation}")
    print(f"  source    {law.source} ({law.confidence})")
    print(f"  use       {law.use}")
    scatter = "not published" if law.scatter is None else f"{law.scatter:.0%} (relative standard deviation)"
    print(f"  scatter   {scatter}")
    rows = ((limit_in_words(each), each.source, "yes" if each.machine_checked else "no") for each in law.range.every)
    print_table(("range", "source of the limit", "checked"), rows)


def _list_scenarios(scenarios: "Iterable[Scenario]") -> None:
    print_table(("name", "title", "measures"), ((s.name, s.title, ", ".join(s.measurements)) for s in scenarios))


def _show_scenario(scenario: "Scenario") -> None:
    print(f"{scenario.name}: {scenario.title}\n{scenario.description}")
    print(f"measures: {', '.join(scenario.measurements)}")
    parameters = declared(scenario.parameters).values()
    rows = ((each.name, _default(each), each.limit(), each.meaning) for each in parameters)
    print_table(("parameter", "default", "allowed", "meaning"), rows)


def _default(parameter: Parameter) -> str:
    if parameter.required:
        return "required"
    return "" if parameter.default is None else value_with_unit(parameter.default, parameter.unit)


def value_with_unit(value: float | str | None, unit: str | None) -> str:
    """A value with its unit, as a sweep document writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "none"
    return readable(value, unit) if unit and not isinstance(value, str) else str(value)
