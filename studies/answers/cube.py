"""The answers to a question as a dataset: every law of a quantity over the axes of the question."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.answers.answer import ShotAnswer, answers
from studies.answers.question import Question
from studies.answers.targets import targets

if TYPE_CHECKING:
    import xarray as xr


def cube_of(question: Question) -> "xr.Dataset":
    """The laws' values in SI over (law, axes); a question without axes has the dimension ``law`` alone.

    For each quantity ``hole_diameter`` there are ``hole_diameter`` (NaN where a law means nothing),
    ``hole_diameter_low`` and ``hole_diameter_high`` over the law's stated variants, ``hole_diameter_in_range``, and
    ``hole_diameter_outside`` with the reasons. A shield has ``probability`` too, ``easier_failed`` and
    ``harder_held``, and the sizes that are just safe: ``safe_wall_thickness_by_risk`` over (risk, axes),
    ``safe_wall_thickness_by_law`` and so on, NaN with a reason (``..._reason``) where there is none.
    """
    import xarray as xr

    every = list(answers(question))
    names = [axis.name for axis in question.axes]
    coordinates: dict[str, Any] = {
        axis.name: (axis.name, list(axis.values), {"units": axis.unit or "1"} if axis.unit else {})
        for axis in question.axes
    }
    coordinates |= {name: value for name, value in question.fixed.items() if value is not None}
    variables: dict[str, Any] = {}
    for place, quantity in enumerate(every[0].quantities):
        laws = sorted({each.law.name: each.law for each in quantity.laws}.values(), key=lambda law: law.name)
        law = f"law_of_{quantity.quantity}"
        dims = (law, *names)
        coordinates[law] = (law, [each.name for each in laws])
        coordinates[f"title_of_{law}"] = (law, [each.title for each in laws])
        coordinates[f"source_of_{law}"] = (law, [each.source for each in laws])
        by_law = [_by_law(every, place, each.name) for each in laws]
        shape = (len(laws), *question.shape)

        def over(attribute: str, dtype: Any, rows: Sequence[Any] = by_law, shape: tuple[int, ...] = shape) -> Any:
            return np.array([getattr(each, attribute) for row in rows for each in row], dtype).reshape(shape)

        about = {"units": quantity.unit, "long_name": quantity.title}
        name = quantity.quantity
        variables |= {
            name: (dims, over("value", float), about),
            f"{name}_low": (dims, over("low", float), about),
            f"{name}_high": (dims, over("high", float), about),
            f"{name}_in_range": (dims, over("in_range", np.int8), {"flag_values": [0, 1], "units": "1"}),
            f"{name}_outside": (dims, over("outside", object)),
        }
    added = targets()[question.target].variables([each.addition for each in every if each.addition], question)
    coordinates, variables = {**coordinates, **added[0]}, {**variables, **added[1]}
    return xr.Dataset(variables, coordinates, {"title": f"Published laws about a {question.target}"})


def _by_law(every: Sequence[ShotAnswer], place: int, law: str) -> list[Any]:
    """A law's answers to every shot, in the order of the shots."""
    return [next(each for each in answer.quantities[place].laws if each.law.name == law) for answer in every]


def netcdf(question: Question) -> bytes:
    """The dataset as the bytes of a NetCDF-4 file."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "laws.nc"
        cube_of(question).to_netcdf(file)
        return file.read_bytes()
