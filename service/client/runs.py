"""A run of a service, for notebooks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from service.cli.console import value_with_unit
from service.notebooks.folder import Animation, table

if TYPE_CHECKING:
    from service.client.connection import Connection

DIGITS = 4  # significant ones, of the numbers that a table shows


class RunDocument(dict[str, Any]):
    """A run as the service describes it; a notebook shows it as a table."""

    def __init__(self, document: Mapping[str, Any], connection: "Connection"):
        super().__init__(document)
        self._connection = connection

    def film(self, field: str = "speed") -> Animation:
        """The film of the run, coloured by a field; raises ServiceError where it was not kept."""
        path = f"/v1/runs/{self['id']}/film.gif"
        return Animation(self._connection.request("GET", path, params={"field": field}).content)

    def _repr_html_(self) -> str:
        """State, parameters and measured values with their units."""
        from studies import measurements, scenarios
        from studies.quantities.parameters import declared

        parameters = declared(scenarios.load(self["scenario"]).parameters)
        units = {name: parameter.unit for name, parameter in parameters.items()}
        units |= {name: measurements.load(name).unit for name in measurements.names()}
        measured = (self["summary"] or {}).get("measurements", {})
        values = {**self["question"]["parameters"], **{name: each["value"] for name, each in measured.items()}}
        rows = [("state", self["state"]), ("reason", self["reason"])]
        for name, value in values.items():
            if value is not None:
                number = float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
                rows.append((name.replace("_", " "), value_with_unit(number, units.get(name))))
        return table(f"run {self['id'][:12]}: {self['scenario']}", rows)
