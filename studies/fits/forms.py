"""The forms of laws whose constants can be fitted: y/d from the data of shots and a few constants, of a volume y/d^3.

A form is linear in its constants, or in the logarithm of y/d, but for the exponents that it names as non-linear.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from studies.laws import Shot

LENGTHS = ("crater_depth", "crater_diameter", "hole_diameter")
VOLUMES = ("crater_volume",)
SIZES = LENGTHS + VOLUMES


def dimension_of(quantity: str) -> int:
    """The power of the projectile's diameter that a quantity is compared with: 3 of a volume."""
    return 3 if quantity in VOLUMES else 1


@dataclass(frozen=True)
class ShotColumns:
    """The data of several shots that forms use, each (shots,)."""

    speed: np.ndarray  # km/s
    thickness_ratio: np.ndarray  # t/d; NaN without a plate
    projectile_density: np.ndarray  # g/cm3


def columns_of(shots: Sequence[Shot]) -> ShotColumns:
    """The data of shots in the units of published forms."""
    return ShotColumns(
        np.array([shot.speed / 1e3 for shot in shots]),
        np.array([shot.thickness_ratio for shot in shots]),
        np.array([shot.projectile.density / 1e3 for shot in shots]),
    )


@dataclass(frozen=True)
class Form:
    """The form of a law: its constants are to be fitted.

    ``design`` gives the columns, each (shots,), that the linear constants multiply, for given values of the
    non-linear ones; of a logarithmic form they add up to ln(y/d), and the first constant is the exponential of its
    own.
    """

    name: str
    title: str
    equation: str  # y stands for the quantity
    quantities: tuple[str, ...]
    linear: tuple[str, ...]  # names of constants
    design: Callable[..., Sequence[np.ndarray]]
    nonlinear: Mapping[str, float] = field(default_factory=dict)  # with the value to start from
    logarithmic: bool = False
    # Of a logarithmic form: the part of ln(y/d) that no constant multiplies.
    offset: Callable[[ShotColumns], np.ndarray] = lambda data: np.zeros_like(data.speed)
    uses_thickness: bool = False
    slowest: float = 0.0  # km/s; the form has no value at or below this speed

    def equation_for(self, quantity: str) -> str:
        """The equation of a quantity: of a volume y/d^3 stands on its left."""
        return self.equation.replace("y/d =", "y/d^3 =") if quantity in VOLUMES else self.equation

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants, the linear ones first."""
        return (*self.linear, *self.nonlinear)

    @property
    def multiplied(self) -> tuple[str, ...]:
        """The constants that the diameter of the projectile multiplies where the quantity is no ratio."""
        return self.linear[:1] if self.logarithmic else self.linear

    def ratio(self, data: ShotColumns, constants: Sequence[float]) -> np.ndarray:
        """y/d (of a volume y/d^3) of each shot, (shots,); NaN where the form has no value."""
        linear, nonlinear = constants[: len(self.linear)], constants[len(self.linear) :]
        with np.errstate(invalid="ignore", divide="ignore"):
            columns = self.design(data, *nonlinear)
            if not self.logarithmic:
                return np.sum([c * x for c, x in zip(linear, columns, strict=True)], axis=0)
            powers = [n * x for n, x in zip(linear[1:], columns[1:], strict=True)]
            return linear[0] * np.exp(np.sum([self.offset(data), *powers], axis=0))


def _ones(data: ShotColumns) -> np.ndarray:
    return np.ones_like(data.speed)


FORMS: Mapping[str, Form] = {
    form.name: form
    for form in (
        Form(
            name="power",
            title="power of the speed",
            equation="y/d = c v^n, v in km/s",
            quantities=SIZES,
            linear=("c", "n"),
            design=lambda data: (_ones(data), np.log(data.speed)),
            logarithmic=True,
        ),
        Form(
            name="linear",
            title="straight line over the speed",
            equation="y/d = a v + b, v in km/s",
            quantities=LENGTHS,
            linear=("a", "b"),
            design=lambda data: (data.speed, _ones(data)),
        ),
        Form(
            # Ma (2005), Eq. 1-2.
            name="two_thirds",
            title="2/3 law",
            equation="y/d = c rho_p^(1/3) v^(2/3), rho_p in g/cm3, v in km/s",
            quantities=("crater_depth", "crater_diameter"),
            linear=("c",),
            design=lambda data: (_ones(data),),
            logarithmic=True,
            offset=lambda data: np.log(data.projectile_density) / 3 + 2 / 3 * np.log(data.speed),
        ),
        Form(
            # Ma (2005), Eq. 1-1: V = K E.
            name="energy",
            title="energy of the projectile",
            equation="y/d = c rho_p v^2, rho_p in g/cm3, v in km/s",
            quantities=VOLUMES,
            linear=("c",),
            design=lambda data: (_ones(data),),
            logarithmic=True,
            offset=lambda data: np.log(data.projectile_density) + 2.0 * np.log(data.speed),
        ),
        Form(
            # Ma (2005), Eq. 1-3.
            name="maiden",
            title="Maiden's form",
            equation="y/d = a v (t/d)^n + b, v in km/s",
            quantities=("hole_diameter",),
            linear=("a", "b"),
            design=lambda data, n: (data.speed * data.thickness_ratio**n, _ones(data)),
            nonlinear={"n": 2 / 3},
            uses_thickness=True,
        ),
        Form(
            name="maiden_two_thirds",
            title="Maiden's form with his exponent",
            equation="y/d = a v (t/d)^(2/3) + b, v in km/s",
            quantities=("hole_diameter",),
            linear=("a", "b"),
            design=lambda data: (data.speed * data.thickness_ratio ** (2 / 3), _ones(data)),
            uses_thickness=True,
        ),
        Form(
            name="thickness",
            title="powers of speed and thickness",
            equation="y/d = c v^m (t/d)^n, v in km/s",
            quantities=("hole_diameter",),
            linear=("c", "m", "n"),
            design=lambda data: (_ones(data), np.log(data.speed), np.log(data.thickness_ratio)),
            logarithmic=True,
            uses_thickness=True,
        ),
        Form(
            # Ma (2005), Eq. 1-4.
            name="zhang_tan",
            title="form of Zhang and Tan",
            equation="y/d = c (v - 1)^m (t/d)^n, v in km/s",
            quantities=("hole_diameter",),
            linear=("c", "m", "n"),
            design=lambda data: (_ones(data), np.log(data.speed - 1.0), np.log(data.thickness_ratio)),
            logarithmic=True,
            uses_thickness=True,
            slowest=1.0,
        ),
    )
}
