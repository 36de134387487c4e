"""Answers about shields as variables of a dataset."""

import math
from collections.abc import Sequence

import numpy as np

from studies import laws
from studies.answers.targets import Variable, Variables
from studies.shields.shield import CRITICAL_DIAMETER
from studies.shields.shots.answers import ShieldAnswer
from studies.shields.shots.inverse import RISKS
from studies.shields.shots.records import NoSize, SafeSize, Size

LAWS = f"{CRITICAL_DIAMETER}_law"  # the dimension
NO_EQUATION = SafeSize(Size.SPHERE, None, None, None, NoSize.NO_EQUATION)


def variables_of(
    shields: Sequence[ShieldAnswer], axes: tuple[str, ...], lengths: tuple[int, ...]
) -> tuple[Variables, Variables]:
    """Coordinates and variables of answers over axes, the last one fastest."""
    variables = dict[str, Variable]()
    equations = [law.name for law in laws.answering(CRITICAL_DIAMETER)]

    def add(
        name: str, title: str, unit: str, values: Sequence[float] | Sequence[str], dims: tuple[str, ...] = ()
    ) -> None:
        shape = (len(values) // len(shields), *lengths) if dims else lengths
        variables[name] = ((*dims, *axes), np.array(values).reshape(shape), {"units": unit, "long_name": title})

    for part, end in (("value", ""), ("low", "_low"), ("high", "_high")):
        chances = [getattr(shield.probability, part, math.nan) for shield in shields]
        add(f"probability{end}", "Probability that the wall fails", "1", chances)
    add("easier_failed", "Easier shots whose wall failed", "1", [shield.easier.contrary for shield in shields])
    add("harder_held", "Harder shots whose wall held", "1", [shield.harder.contrary for shield in shields])
    found = [{(safe.size, safe.risk or safe.law): safe for safe in shield.safe} for shield in shields]
    for size in Size:
        for dim, by, limits in (("risk", "risk", RISKS), (LAWS, "law", equations)):
            sizes = [safe.get((size, limit), NO_EQUATION) for limit in limits for safe in found]
            name, title = f"safe_{size}_by_{by}", f"{size.replace('_', ' ')} that is just safe"
            add(name, title, "m", [math.nan if safe.value is None else safe.value for safe in sizes], (dim,))
            add(f"{name}_reason", "why there is none", "1", [str(safe.reason or "") for safe in sizes], (dim,))
    return {"risk": ("risk", list(RISKS), {"units": "1"})}, variables
