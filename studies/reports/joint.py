"""The joint uncertainty of a simulated value and a law, with its named parts."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import SUCCEEDED, error_bars


@dataclass(frozen=True)
class JointUncertainty:
    """Standard uncertainties of a law minus the simulation at each point, in the quantity's unit."""

    parts: Mapping[str, np.ndarray]  # by name, (points,); NaN: not assessed, or not published
    # Root of the sum of the squares of the parts that there are, (points,); NaN where the numerical part lacks the
    # mesh: nothing is judged there.
    total: np.ndarray

    @property
    def numerics_only(self) -> np.ndarray:
        """Where nothing is known of the model, so that no law is refuted: bool (points,)."""
        return np.isnan(self.parts["model"])


def joint_uncertainty(points: xr.Dataset, quantity: str, law: str = "") -> JointUncertainty:
    """The joint uncertainty at the points of a cube (``points_of``), with a law's scatter where its label is stated.

    Parts: ``numerical`` (the error bar, where it includes the mesh), ``definition``, ``model`` and, with a law,
    ``scatter`` (as published, times the law's value).
    """
    parts = {
        "numerical": error_bars(points, quantity).values.ravel(),
        "definition": _stored(points, f"{quantity}_definition_part"),
        "model": _stored(points, cubes.MODEL_PART.named(quantity)),
    }
    if law:
        parts["scatter"] = law_scatter(points, quantity, law)
    known = reduce(np.hypot, (np.nan_to_num(part) for part in parts.values()))
    return JointUncertainty(parts, np.where(np.isnan(parts["numerical"]), np.nan, known))


def _stored(points: xr.Dataset, name: str) -> np.ndarray:
    """A part that the cube holds, where the run succeeded; NaN where it does not hold it."""
    if name not in points:
        return np.full(points.run_state.size, np.nan)
    succeeded = reading.by_run(points, points.run_state) == SUCCEEDED
    return np.where(succeeded, reading.by_run(points, points[name]), np.nan).ravel()


def law_scatter(points: xr.Dataset, quantity: str, law: str) -> np.ndarray:
    """The published scatter of a law, in the unit of the quantity; NaN where none is published."""
    answers = cubes.BY_LAW.of(points, quantity)
    along = str(answers.dims[-1])
    row = list(answers[along].values).index(law)
    if not cubes.LAW_SCATTER.is_in(points, quantity):
        return np.full(points.run_state.size, np.nan)
    scatter = float(cubes.LAW_SCATTER.of(points, quantity).values[row])
    return np.abs(answers.isel({along: row}).values.ravel()) * scatter
