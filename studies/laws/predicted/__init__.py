"""What laws predict and no run measures; features add theirs by the entry points ``whipple.studies.laws.predicted``."""

from collections.abc import Mapping
from dataclasses import dataclass

from solver.registry import entries


@dataclass(frozen=True)
class Predicted:
    """A quantity that laws predict and no run measures: it is listed and drawn."""

    name: str
    title: str
    place: int  # in lists
    outcome: str = ""  # what a run measures as 1 or 0; the quantity is the projectile's diameter from which on it is 1


PREDICTED = (
    Predicted("spall_thickness", "Plate thickness below which the back face spalls", 10),
    Predicted("detached_spall_thickness", "Plate thickness below which spall detaches", 20),
    Predicted("perforation_thickness", "Plate thickness below which a plate is perforated", 30),
    Predicted("plate_critical_diameter", "Projectile diameter above which a plate is perforated", 40),
)


def unmeasured() -> Mapping[str, str]:
    """The title of each quantity that laws predict and no run measures, in the order of lists."""
    return {quantity.name: quantity.title for quantity in _every()}


def critical() -> Mapping[str, str]:
    """The diameter that laws predict for each outcome that a run measures as 1 or 0."""
    return {quantity.outcome: quantity.name for quantity in _every() if quantity.outcome}


def _every() -> list[Predicted]:
    return sorted(entries(__name__, "PREDICTED").values(), key=lambda predicted: predicted.place)
