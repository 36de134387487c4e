"""The laws of a body's matter, together: what the stress update takes."""

from typing import NamedTuple

from solver.jit import Record
from solver.matter.eos import EosRecord
from solver.matter.failure.none import NoFailure
from solver.matter.melting import MeltingCurve
from solver.units import Dimensionless, Kelvin, Pascal


class Matter(NamedTuple):
    """The matter of a body: one record for each law."""

    eos: EosRecord
    strength: Record
    tension: Record
    shear_modulus: Pascal
    room_temperature: Kelvin
    melt_temperature: Kelvin  # at the density of ``melting.anchor``; inf: never softens, never melts
    failure: Record = NoFailure()
    rubble_friction: Dimensionless = 0.0  # shear strength of failed matter over its pressure
    melting: MeltingCurve = MeltingCurve()
