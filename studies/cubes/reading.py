"""Reading of a cube: its quantities, versions, confidences and flags, and values for each run."""

import json
import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import xarray as xr

from studies.cubes.variables import FLAGS, FLAGS_OF_RUN, LAW_LABEL, RUN_ID, STOP_REASON
from studies.laws import critical
from studies.quantities.measured import ERROR_UNKNOWN, STILL_GROWING
from studies.sweeps.reading import END

Item = TypeVar("Item")


def quantities_of(dataset: xr.Dataset) -> list[str]:
    """Names of the measured quantities of a cube."""
    return str(dataset.attrs["quantities"]).split()


def critical_of(dataset: xr.Dataset) -> list[str]:
    """Names of the diameters that laws predict for the outcomes of a cube."""
    return [name for name in critical().values() if LAW_LABEL.is_in(dataset, name)]


def finite(value: Item) -> Item | None:
    """A value as JSON has it: None in place of a number that is none."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def mixed_versions(dataset: xr.Dataset, quantity: str) -> list[int]:
    """Versions of the definition of a quantity, where the runs of a cube were measured with several; else none."""
    versions: list[int] = json.loads(dataset.attrs["measurement_versions"]).get(quantity, [])
    return versions if len(versions) > 1 else []


def meaning_of(array: xr.DataArray) -> str:
    """The definition of a variable of a cube."""
    return str(array.attrs.get("comment") or array.attrs["long_name"])


def flag_meanings(flags: xr.DataArray) -> list[tuple[int, str]]:
    """Bit and meaning of each flag of a mask."""
    masks: Sequence[int] = np.atleast_1d(flags.attrs["flag_masks"]).tolist()
    return list(zip(masks, str(flags.attrs["flag_meanings"]).split(), strict=True))


def flag_words(flags: xr.DataArray) -> list[tuple[str, ...]]:
    """The flags of each cell in words, in the order of ``values.ravel()``."""
    meanings = flag_meanings(flags)
    return [tuple(word for mask, word in meanings if value & mask) for value in flags.values.ravel()]


def doubts(flags: xr.DataArray) -> xr.DataArray:
    """The flags that doubt a value: all but those that say how well its error is known."""
    unknown = sum(mask for mask, word in flag_meanings(flags) if word == ERROR_UNKNOWN)
    return flags & ~np.int32(unknown)


def doubts_at(dataset: xr.Dataset, quantity: str) -> list[tuple[str, ...]]:
    """The flags that doubt a quantity at each cell, in words: its own, then those of the run."""
    words = flag_words(doubts(FLAGS.of(dataset, quantity))), flag_words(FLAGS_OF_RUN.of(dataset))
    return [(*own, *of_run) for own, of_run in zip(*words, strict=True)]


def still_growing(dataset: xr.Dataset) -> set[str]:
    """The ids of the runs that ended at their latest end with a quantity that was still growing."""
    ended = STOP_REASON.of(dataset).values.ravel() == END
    flags = [flag_words(FLAGS.of(dataset, name)) for name in quantities_of(dataset)]
    growing = np.array([any(STILL_GROWING in words for words in of_run) for of_run in zip(*flags, strict=True)], bool)
    return {str(id) for id in RUN_ID.of(dataset).values.ravel()[ended & growing]}


def by_run(dataset: xr.Dataset, variable: xr.Variable) -> np.ndarray:
    """The values of a variable for each run, in the shape of ``run_state``, whatever it varies along.

    Without xarray's alignment, which takes milliseconds: the variables of a cube share their coordinates.
    """
    return variable.set_dims(dict(dataset.variables["run_state"].sizes)).values
