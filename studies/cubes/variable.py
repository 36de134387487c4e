"""A variable of the cube: name, dimensions, unit, meaning, group, and how its values are picked from records."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
import xarray as xr

VariableKind = Literal["number", "integer", "text", "flag", "mask"]
DTYPES = {"number": float, "integer": np.int32, "text": object, "flag": np.int8, "mask": np.int32}
EMPTY = {"number": np.nan, "integer": 0, "text": "", "flag": 0, "mask": 0}

# Of the file (``groups``); the first is its root.
Group = Literal["", "laws", "observations", "refinement", "quantities", "runs", "inputs"]
GROUPS: tuple[Group, ...] = get_args(Group)
ROOT = GROUPS[0]
LONGEST_LABEL = 40  # characters of a long_name: longer ones are cut off beside an axis

# Lengths that the field states over the diameter of the projectile, as it writes them.
SYMBOLS = {"hole_diameter": "D/d", "crater_depth": "p/d", "crater_diameter": "D/d"}

RUNS, POINTS = ("*",), ("@",)  # stand for the dimensions of the runs and of the points


OUTCOMES, BETWEEN_OUTCOMES = "outcomes", "; "  # the attribute that says what 0 and 1 of a quantity mean


@dataclass(frozen=True)
class Quantity:
    """Something that is measured on a run, as its measurement describes it."""

    name: str  # "hole_diameter"
    unit: str  # "m"
    meaning: str
    outcomes: tuple[str, ...] = ()  # what 0 and 1 mean, of an outcome
    first: bool = True  # at the root of the file


@dataclass(frozen=True)
class Variable:
    """A variable of the cube."""

    name: str
    meaning: str
    pick: Callable[..., Any]  # the value of one record; None where it has none
    dims: tuple[str, ...]
    unit: str | None = None  # UDUNITS; None for text and flags
    kind: VariableKind = "number"
    # Meanings of the values 0, 1, ... of a flag, or of the bits of a mask.
    meanings: tuple[str, ...] = ()
    label: str = ""  # a few words for an axis; by default the meaning, or the name where that is long
    group: Group = "quantities"

    @property
    def long_name(self) -> str:
        """The label of an axis: at most ``LONGEST_LABEL`` characters."""
        if self.label:
            return self.label
        return self.meaning if len(self.meaning) <= LONGEST_LABEL else self.name.replace("_", " ")

    @property
    def comment(self) -> str:
        """The definition, where the label does not say it; else empty."""
        return "" if self.meaning == self.long_name else self.meaning

    @property
    def attributes(self) -> dict[str, str | np.ndarray]:
        """Unit, label and definition; the meanings of a flag."""
        attributes: dict[str, str | np.ndarray] = {} if self.unit is None else {"units": self.unit}
        attributes["long_name"] = self.long_name
        if self.comment:
            attributes["comment"] = self.comment
        if self.kind == "flag":
            attributes["flag_values"] = np.arange(len(self.meanings), dtype=np.int8)
            attributes["flag_meanings"] = " ".join(self.meanings)
        return attributes

    def filled(self, quantity: Quantity) -> "Variable":
        """The variable of one quantity."""
        filling = {
            "quantity": quantity.name,
            "words": quantity.name.replace("_", " "),
            "unit": quantity.unit,
            "meaning": quantity.meaning,
            "symbol": SYMBOLS.get(quantity.name, f"{quantity.name}/d"),
        }
        return replace(
            self,
            name=self.name.format(**filling),
            dims=tuple(dim.format(**filling) for dim in self.dims),
            unit=self.unit and self.unit.format(**filling),
            meaning=self.meaning.format(**filling),
            label=self.label.format(**filling),
            group=self.group or (ROOT if quantity.first else "quantities"),
        )

    def named(self, quantity: str = "") -> str:
        """The name that it has in a cube."""
        return self.name.format(quantity=quantity)

    def is_in(self, dataset: xr.Dataset, quantity: str = "") -> bool:
        """Whether a cube has it."""
        return self.named(quantity) in dataset

    def of(self, dataset: xr.Dataset, quantity: str = "") -> xr.DataArray:
        """Its values in a cube."""
        return dataset[self.named(quantity)]

    def values(self, records: np.ndarray) -> np.ndarray:
        """One value a record, of an array of records (objects; None has no value)."""
        values = np.full(records.shape, EMPTY[self.kind], DTYPES[self.kind])
        for place, record in np.ndenumerate(records):
            picked = None if record is None else self.pick(record)
            if picked is not None:
                values[place] = self.meanings.index(picked) if self.kind == "flag" else picked
        return values


def is_reading(name: str, names: Iterable[str]) -> bool:
    """Whether a quantity is another reading of one of these: ``hole_diameter_lip`` of ``hole_diameter``."""
    return any(name.startswith(f"{other}_") for other in names if other != name)


# A variable with its values and further attributes.
Column = tuple[Variable, np.ndarray, Mapping[str, str | np.ndarray]]


def variable_name(parameter: str) -> str:
    """A parameter's path as a CF name.

    >>> variable_name("target.strength.A")
    'target_strength_A'
    """
    return re.sub(r"\W", "_", parameter)
