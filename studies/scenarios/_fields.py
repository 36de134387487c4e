"""How a scenario declares its parameters: fields with a meaning and bounds."""

from dataclasses import field
from typing import Any


def described(meaning: str, minimum: float, maximum: float, **default: Any) -> Any:
    """A field with its meaning and bounds (SI)."""
    return field(**default, metadata={"meaning": meaning, "minimum": minimum, "maximum": maximum})


def explained(meaning: str, **default: Any) -> Any:
    """A field that is not a number, with its meaning."""
    return field(**default, metadata={"meaning": meaning})


def label(meaning: str, **default: Any) -> Any:
    """A field that only names what other fields hold: no part of a run's identity."""
    return field(**default, metadata={"meaning": meaning, "label": True})
