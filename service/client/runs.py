"""A run of a service, for notebooks."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from service.notebooks.folder import Animation, table
from studies.quantities.display import with_bar
from studies.quantities.units import readable

if TYPE_CHECKING:
    from service.client.connection import Connection

DIGITS = 4  # of a measured value


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
        rows = [("state", self.get("state")), ("reason", self.get("reason"))]
        rows += [*self._parameters(), *self._measured()]
        return table(f"run {self.get('id', '')[:12]}: {self.get('scenario', '')}", rows)

    def _parameters(self) -> Iterator[tuple[str, str]]:
        """The parameters of the run with their units."""
        from studies import scenarios
        from studies.quantities.parameters import declared

        question = self.get("question") or {}
        parameters = question.get("parameters") or {}
        allowed = declared(scenarios.load(question["scenario"]).parameters) if parameters else {}
        for name, value in parameters.items():
            yield name.replace("_", " "), _with_unit(value, allowed[name].unit if name in allowed else None)

    def _measured(self) -> Iterator[tuple[str, str]]:
        """The measured values of the run with their units."""
        from studies import measurements

        known = set(measurements.names())
        for name, measured in ((self.get("summary") or {}).get("measurements") or {}).items():
            value = _with_unit(measured["value"], measurements.load(name).unit if name in known else None)
            yield name.replace("_", " "), with_bar(value, None) if value else ""


def _with_unit(value: object, unit: str | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool | str) or unit is None or not isinstance(value, int | float):
        return str(value)
    return readable(float(f"{value:.{DIGITS}g}"), unit)
