"""Runs that were still growing at their latest end."""

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.quantities.measured import STILL_GROWING
from studies.sweeps.reading import END


def still_growing(dataset: xr.Dataset) -> set[str]:
    """The ids of the runs that ended at their latest end with a quantity that was still growing."""
    ended = cubes.STOP_REASON.of(dataset).values.ravel() == END
    flags = [reading.flag_words(cubes.FLAGS.of(dataset, name)) for name in reading.quantities_of(dataset)]
    growing = np.array([any(STILL_GROWING in words for words in of_run) for of_run in zip(*flags, strict=True)], bool)
    return {str(id) for id in cubes.RUN_ID.of(dataset).values.ravel()[ended & growing]}
