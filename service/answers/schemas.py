"""Response models of answers of laws, and what targets add to them, for the components of OpenAPI."""

from typing import Any, get_type_hints

from pydantic import BaseModel, Field, create_model
from pydantic.json_schema import models_json_schema

from service.api.schemas import COMPONENTS, Answer, LawModel
from studies.answers.targets import Addition, targets
from studies.laws import RangeStatus
from studies.quantities.parameters import Value
from studies.sweeps.schema import Schemas


class LawAnswerModel(Answer):
    """The value of a law for a shot, in SI units, with its range."""

    law: str = Field(description="Its name, under which `laws` has the rest")
    value: float | None = Field(description="Null where the law means nothing: see `outside`")
    low: float | None = Field(description="Over the law's stated variants")
    high: float | None
    in_range: bool
    range_status: RangeStatus
    outside: str = Field(description="By which limits the shot is outside of its range, and by how much")


class SpreadModel(Answer):
    """Smallest and largest value of the laws in range, SI."""

    low: float
    high: float
    laws: int


class QuantityAnswerModel(Answer):
    """Every law of one quantity about a shot."""

    quantity: str
    title: str
    unit: str = Field(description="SI symbol")
    laws: list[LawAnswerModel]
    spread: SpreadModel | None = Field(description="Null where no law is in range")


class NearShotModel(Answer):
    """A published shot, SI."""

    quantity: str
    value: float | None = Field(description="Null of a range: see `bounds`")
    bounds: tuple[float | None, float | None] | None
    uncertainty: float | None
    parameters: dict[str, Value]
    source: str
    confidence: str
    note: str
    apart: float = Field(description="Root of the summed squares of ln ratios of speed, diameter and thickness")


class ShotAnswerModel(Answer):
    """What laws and shots say of one shot; what its target says besides stands under the name of that."""

    headline: str
    parameters: dict[str, Value] = Field(description="Of the shot, SI")
    quantities: list[QuantityAnswerModel]
    shots: list[NearShotModel] = Field(description="Published ones, nearest first")


class AxisModel(Answer):
    """A parameter with several values."""

    unit: str | None = Field(description="SI symbol; null for text")
    values: list[Value]


class LawsAnswerModel(Answer):
    """The answer to each shot of a question, the last axis fastest, and what the catalogue says of each law."""

    target: str
    axes: dict[str, AxisModel]
    laws: dict[str, LawModel]


def answer_schemas(name: str) -> Schemas:
    """The schemas of an answer, the whole under a name."""
    return models_json_schema([(answer_model(name), "serialization")], ref_template=COMPONENTS + "{model}")[1]["$defs"]


def answer_model(name: str = "LawsAnswer") -> type[BaseModel]:
    """The model of an answer, with what the targets add."""
    added: dict[str, Any] = {
        each: (_added(target.addition) | None, ...) for each, target in targets().items() if target.addition
    }
    item: Any = create_model("ShotAnswerModel", __base__=ShotAnswerModel, __doc__=ShotAnswerModel.__doc__, **added)
    items: Any = (list[item], ...)
    return create_model(name, __base__=LawsAnswerModel, __doc__=LawsAnswerModel.__doc__, items=items)


def _added(record: type[Addition]) -> type[BaseModel]:
    """The model of what a target says besides its laws."""
    hints: dict[str, Any] = {"sentence": str, **get_type_hints(record)}
    fields: dict[str, Any] = {name: (hint, ...) for name, hint in hints.items()}
    return create_model(f"{record.__name__}Model", __base__=Answer, __doc__=record.__doc__, **fields)
