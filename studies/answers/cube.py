"""The answers to a question as a dataset: every law of a quantity over the axes of the question."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.answers.answer import answers
from studies.answers.question import Question, read_question
from studies.answers.targets import Variable, targets
from studies.quantities.arrays import plain
from studies.quantities.parameters import Value

if TYPE_CHECKING:
    import xarray as xr


def cube_of(question: Question) -> "xr.Dataset":
    """The laws' values in SI over axes and law, by the names of a cube's group ``laws``.

    For each quantity ``hole_diameter`` there are ``hole_diameter_by_law`` (NaN where a law means nothing) over
    ``hole_diameter_law``, ``hole_diameter_by_law_low`` and ``_high`` over the law's stated variants,
    ``hole_diameter_by_law_in_range``, and ``hole_diameter_by_law_reason``. A shield has ``probability`` too,
    ``easier_failed`` and ``harder_held``, and the sizes that are just safe: ``safe_wall_thickness_by_risk`` over
    (axes, risk), ``safe_wall_thickness_by_law`` and so on, NaN with a reason (``..._reason``) where there is none.
    """
    import xarray as xr

    from studies.cubes import variables as cubes
    from studies.cubes.variable import Quantity

    every = list(answers(question))
    names = tuple(axis.name for axis in question.axes)
    coordinates: dict[str, Variable | Value] = {
        axis.name: (axis.name, list(axis.values), {"units": axis.unit or "1"} if axis.unit else {})
        for axis in question.axes
    }
    coordinates |= {name: value for name, value in question.fixed.items() if value is not None}
    variables: dict[str, Variable] = {}
    for place, quantity in enumerate(every[0].quantities):
        laws = sorted((answer.law for answer in quantity.laws), key=lambda law: law.name)
        asked = Quantity(quantity.quantity, quantity.unit, quantity.title)
        dim = cubes.LAW_LABEL.named(asked.name)
        coordinates[dim] = (dim, [law.name for law in laws], {})
        coordinates[cubes.LAW_TITLE.named(asked.name)] = (dim, [law.title for law in laws], {})
        coordinates[cubes.LAW_SOURCE.named(asked.name)] = (dim, [law.source for law in laws], {})
        by_name = [{law.law.name: law for law in answer.quantities[place].laws} for answer in every]
        rows = [by_law[law.name] for law in laws for by_law in by_name]  # the last axis fastest
        shape, dims = (len(laws), *question.shape), (dim, *names)
        for variable, end, values in (
            (cubes.BY_LAW, "", np.array([row.value for row in rows])),
            (cubes.BY_LAW, "_low", np.array([row.low for row in rows])),
            (cubes.BY_LAW, "_high", np.array([row.high for row in rows])),
            (cubes.BY_LAW_IN_RANGE, "", np.array([row.in_range for row in rows], np.int8)),
            (cubes.BY_LAW_REASON, "", np.array([row.outside for row in rows], np.object_)),
        ):
            about = variable.filled(asked).attributes
            variables[f"{variable.named(asked.name)}{end}"] = (dims, values.reshape(shape), about)
    if addition := targets()[question.target].addition:
        additions = [answer.addition for answer in every if answer.addition]
        added = addition.variables(additions, names, question.shape)
        coordinates, variables = {**coordinates, **added[0]}, {**variables, **added[1]}
    dataset = xr.Dataset(variables, coordinates, {"title": f"Published laws about a {question.target}"})
    return dataset.transpose(*names, ...)


def netcdf(question: Question) -> bytes:
    """The dataset as the bytes of a NetCDF-4 file."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "laws.nc"
        cube_of(question).to_netcdf(file)
        return file.read_bytes()


def laws(**parameters: Any) -> "xr.Dataset":
    """What every published law says of a shot, or of many, without a run: values in SI over axes and law.

    Parameters are those of ``whipple laws``, with units: ``speed="6 km/s"``, ``projectile``, ``projectile_diameter``,
    ``target`` of a plate or a block, ``plate_thickness`` of a plate; ``bumper``, ``bumper_thickness``, ``stand_off``,
    ``wall``, ``wall_thickness`` and the list ``further_bumpers`` of a shield. A list of values makes an axis, and so
    does an array: ``speed=(np.linspace(2, 7, 11), "km/s")``, or one of pint. Of a shield there are also the
    ``probability`` to fail and the sizes that are just safe. Raises InvalidInput.

    >>> import whipple
    >>> shot = dict(projectile="al-2017-t4", projectile_diameter="5 mm", target="al-6061-t6", plate_thickness="2 mm")
    >>> answer = whipple.laws(speed=["3 km/s", "6 km/s"], **shot)
    >>> (1e3 * answer.hole_diameter_by_law.sel(hole_diameter_law="maiden_al")).round(2).values.tolist()
    [8.16, 11.83]
    """
    return cube_of(read_question(plain(parameters)))
