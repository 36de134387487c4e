"""What ships as tables of pandas, in SI: ``whipple.materials``."""

from typing import TYPE_CHECKING

from studies import materials as shipped

if TYPE_CHECKING:
    import pandas as pd


def materials(name: str | None = None) -> "pd.DataFrame":
    """The materials that ship, a row each; or the constants of one with value, unit, source and confidence.

    Raises InvalidInput with the nearest names.

    >>> import whipple
    >>> whipple.materials("copper-ofhc").unit["density"]
    'kg m-3'
    """
    import pandas as pd

    if name is not None:
        return pd.DataFrame.from_dict(shipped.load(name).sources, orient="index")
    rows = {
        each.name: {
            **{"title": each.title, "family": each.family, "alloy": each.alloy, "density": each.density},
            **{"eos": each.eos.kind, "strength": each.strength.kind},
        }
        for each in map(shipped.load, shipped.names())
    }
    return pd.DataFrame.from_dict(rows, orient="index")
