"""Measured shots on shields as a table of pandas: ``whipple.shots``."""

from typing import TYPE_CHECKING, Any

from studies.quantities.arrays import plain
from studies.quantities.parameters import declared
from studies.shields.shots.table import ShieldShot, filtered, published, read_filters

if TYPE_CHECKING:
    import pandas as pd


def shots(**where: Any) -> "pd.DataFrame":
    """Measured shots on Whipple shields, with what became of the wall, a row each, SI; units are in ``attrs["units"]``.

    ``where`` chooses by columns: a beginning of a text (``wall="AA2219"``), a number with its unit or a range of them
    (``speed="6 km/s to 7 km/s"``). Raises InvalidInput with the nearest column.

    >>> import whipple
    >>> shots = whipple.shots(speed="6 km/s to 7 km/s", wall="AA2219")
    >>> bool((shots.speed >= 6000.0).all()), sorted({*shots.outcome})
    (True, ['held', 'perforated'])
    """
    import pandas as pd

    found = filtered(published().shots, *read_filters([f"{name}={plain(value)}" for name, value in where.items()]))
    columns = declared(ShieldShot)
    frame = pd.DataFrame([vars(shot) for shot in found], columns=[*columns])
    frame.attrs["units"] = {name: column.unit for name, column in columns.items() if column.unit}
    return frame
