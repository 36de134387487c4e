"""The CF checker on a file: what it complains about."""

from pathlib import Path

from compliance_checker.base import BaseCheck
from compliance_checker.runner import CheckSuite

CHECKER = "cf:1.11"
# The checker itself stumbles over a dimension that is labelled by words.
STUMBLES = ("check_coordinate_variables_strict_monotonicity",)


def complaints(file: Path, at_least: int = BaseCheck.HIGH) -> list[str]:
    """Messages of every check of this weight (HIGH: errors; MEDIUM: warnings too) that failed."""
    CheckSuite.load_all_available_checkers()
    suite = CheckSuite()
    results, stumbled = suite.run_all(suite.load_dataset(str(file)), [CHECKER])[CHECKER]
    failed = [
        message
        for result in results
        if result.weight >= at_least and _failed(result)
        for message in result.msgs or [str(result.name)]
    ]
    return failed + [str(check) for check in stumbled if check not in STUMBLES]


def _failed(result: object) -> bool:
    value = getattr(result, "value", None)
    return value[0] < value[1] if isinstance(value, tuple) else not value
