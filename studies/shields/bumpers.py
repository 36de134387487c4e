"""The bumpers of a shield behind its first one: parameters by their place, or a list in a document."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Self

from solver.units import Described, Metre
from studies.quantities.findings import Finding, Renamed
from studies.quantities.parameters import MaterialName, Places
from studies.quantities.units import readable

BUMPERS = ("bumper", "bumper_2", "bumper_3", "bumper_4")  # by their place: a shield has the first, and may have more
PLACES = Places(
    BUMPERS[1:], "bumper", "further_bumpers", "{bumper: al-6061-t6, bumper_thickness: 1 mm, stand_off: 5 cm}"
)
RENAMED = Renamed(
    "shields",
    {
        **dict.fromkeys(("target", "inner_bumper", "bumper_material"), "bumper"),
        **{"plate_thickness": "bumper_thickness", "inner_thickness": "bumper_2_thickness"},
        **{"inner_stand_off": "bumper_2_stand_off", "projectile_material": "projectile"},
        **dict.fromkeys(("rear_wall", "back_wall", "wall_material"), "wall"),
        **dict.fromkeys(("rear_wall_thickness", "back_wall_thickness"), "wall_thickness"),
        **dict.fromkeys(("standoff", "spacing", "gap"), "stand_off"),
    },
)


@dataclass(frozen=True, kw_only=True)
class Bumper:
    """A bumper behind the first one, which is there where it has a thickness."""

    bumper: Annotated[MaterialName | None, Described("material of {place}")] = None
    bumper_thickness: Annotated[Metre | None, Described("thickness of {place}, 0 for none", 0.0, 1.0)] = None
    stand_off: Annotated[Metre | None, Described("space behind {place}", 1e-4, 10.0)] = None


@dataclass(frozen=True, kw_only=True)
class FurtherBumpers:
    """The bumpers behind the first one, the outermost first.

    >>> from studies.quantities.parameters import by_place
    >>> bumper = {"bumper": "al-6061-t6", "bumper_thickness": "1 mm"}
    >>> by_place({"stand_off": "4 cm", "further_bumpers": [bumper]}, "fixed", FurtherBumpers)
    {'stand_off': '4 cm', 'bumper_2': 'al-6061-t6', 'bumper_2_thickness': '1 mm'}
    """

    bumpers: Annotated[tuple[Bumper, ...], PLACES] = ()

    def filled(self) -> Self:
        """Without those at the end that have no thickness."""
        count = max((place for place, bumper in enumerate(self.bumpers, 1) if bumper.bumper_thickness), default=0)
        return replace(self, bumpers=self.bumpers[:count])

    def check(self) -> Iterator[Finding]:
        """A bumper has a space behind it and another one in front of it."""
        missing = ""  # the first place without a bumper
        for name, bumper in zip(BUMPERS[1:], self.bumpers, strict=False):
            if not bumper.bumper_thickness:
                missing = missing or name
            elif missing:
                value, limit = readable(bumper.bumper_thickness, "m"), f"0 m without {missing}"
                yield Finding(f"{name}_thickness", value, limit, f"give {missing}_thickness")
            elif bumper.stand_off is None:
                behind = f"{name}_stand_off"
                yield Finding(behind, "nothing", f"the space behind {name}", f"give {behind}")
