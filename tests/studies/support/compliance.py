"""The CF checker on a file: what it complains about."""

from contextlib import ExitStack
from functools import cache
from pathlib import Path
from unittest.mock import patch

from compliance_checker.base import BaseCheck
from compliance_checker.cf import util
from compliance_checker.runner import CheckSuite

CHECKER = "cf:1.11"
# The checker itself stumbles over a dimension that is labelled by words.
STUMBLES = ("check_coordinate_variables_strict_monotonicity",)

# Questions about the whole file that the checker asks anew for each variable: nine tenths of its time.
ASKED_OFTEN = (
    "get_auxiliary_coordinate_variables",
    "get_axis_variables",
    "get_cell_boundary_variables",
    "get_climatology_variable",
    "get_forecast_metadata_variables",
    "get_time_variables",
    "get_z_variables",
)


def complaints(file: Path) -> list[str]:
    """Messages of every check for errors that failed."""
    CheckSuite.load_all_available_checkers()
    suite = CheckSuite()
    with ExitStack() as ends:
        for name in ASKED_OFTEN:
            ends.enter_context(patch.object(util, name, cache(getattr(util, name))))
        results, stumbled = suite.run_all(suite.load_dataset(str(file)), [CHECKER])[CHECKER]
    failed = [
        message
        for result in results
        if result.weight >= BaseCheck.HIGH and _failed(result)
        for message in result.msgs or [str(result.name)]
    ]
    return failed + [str(check) for check in stumbled if check not in STUMBLES]


def _failed(result: object) -> bool:
    value = getattr(result, "value", None)
    return value[0] < value[1] if isinstance(value, tuple) else not value
