"""The bumpers of a shield behind its first one: parameters by their place, and the list that a document has of them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from solver.units import Described, Metre
from studies.quantities.findings import Finding, InvalidInput, refusal, unknown_keys
from studies.quantities.parameters import MaterialName
from studies.quantities.units import readable

BUMPERS = ("bumper", "bumper_2", "bumper_3", "bumper_4")  # by their place: a shield has the first, and may have more
LIST = "further_bumpers"  # the key of a document
# A further bumper in the list has the words of the first one: the end of a parameter's name by each of them.
WORDS: Mapping[str, str] = {"bumper": "", "bumper_thickness": "_thickness", "stand_off": "_stand_off"}


def by_place(values: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Values of parameters with those of the list of further bumpers in its place; raises InvalidInput.

    >>> by_place({"stand_off": "4 cm", "further_bumpers": [{"bumper": "al-6061-t6", "bumper_thickness": "1 mm"}]})
    {'stand_off': '4 cm', 'bumper_2': 'al-6061-t6', 'bumper_2_thickness': '1 mm'}
    """
    if LIST not in values:
        return dict(values)
    bumpers, field = values[LIST], f"{path}.{LIST}" if path else LIST
    limit = f"a list of at most {len(BUMPERS) - 1} bumpers, each with {', '.join(WORDS)}"
    if not isinstance(bumpers, list | tuple) or len(bumpers) >= len(BUMPERS):
        raise refusal(field, bumpers, limit, "write [{bumper: al-6061-t6, bumper_thickness: 1 mm, stand_off: 5 cm}]")
    placed = {name: value for name, value in values.items() if name != LIST}
    for number, (name, bumper) in enumerate(zip(BUMPERS[1:], bumpers, strict=False)):
        if not isinstance(bumper, Mapping):
            raise refusal(f"{field}[{number}]", bumper, limit, "write {bumper: al-6061-t6, bumper_thickness: 1 mm}")
        if findings := [*unknown_keys(bumper, WORDS, f"{field}[{number}]", "a word of a bumper")]:
            raise InvalidInput(findings)
        for word, value in bumper.items():
            if f"{name}{WORDS[word]}" in placed:
                raise refusal(f"{field}[{number}].{word}", value, "each value once", f"remove {name}{WORDS[word]}")
            placed[f"{name}{WORDS[word]}"] = value
    return placed


def _has(count: int) -> Callable[[Any], bool]:
    """Whether a shield has so many bumpers."""
    return lambda record: all(getattr(record, f"{name}_thickness") for name in BUMPERS[1:count])


@dataclass(frozen=True, kw_only=True)
class FurtherBumpers:
    """The bumpers behind the first one: each is there where it has a thickness, and all in front of it have."""

    bumper_2: Annotated[MaterialName | None, Described("material of a second bumper", acts=_has(2))] = None
    bumper_2_thickness: Annotated[
        Metre, Described("thickness of a second bumper, 0 for none", 0.0, 1.0, neutral=True)
    ] = 0.0
    bumper_2_stand_off: Annotated[
        Metre | None, Described("space behind the second bumper", 1e-4, 10.0, acts=_has(2))
    ] = None
    bumper_3: Annotated[MaterialName | None, Described("material of a third bumper", acts=_has(3))] = None
    bumper_3_thickness: Annotated[
        Metre, Described("thickness of a third bumper, 0 for none", 0.0, 1.0, neutral=True)
    ] = 0.0
    bumper_3_stand_off: Annotated[
        Metre | None, Described("space behind the third bumper", 1e-4, 10.0, acts=_has(3))
    ] = None
    bumper_4: Annotated[MaterialName | None, Described("material of a fourth bumper", acts=_has(4))] = None
    bumper_4_thickness: Annotated[
        Metre, Described("thickness of a fourth bumper, 0 for none", 0.0, 1.0, neutral=True)
    ] = 0.0
    bumper_4_stand_off: Annotated[
        Metre | None, Described("space behind the fourth bumper", 1e-4, 10.0, acts=_has(4))
    ] = None

    def check(self) -> Iterator[Finding]:
        """A bumper has a space behind it and another one in front of it."""
        for place, name in enumerate(BUMPERS[1:], 2):
            thickness, behind = f"{name}_thickness", f"{name}_stand_off"
            if getattr(self, thickness) and not _has(place)(self):
                value, before = readable(getattr(self, thickness), "m"), f"{BUMPERS[place - 2]}_thickness"
                yield Finding(thickness, value, f"0 m without {BUMPERS[place - 2]}", f"give {before}")
            elif getattr(self, thickness) and getattr(self, behind) is None:
                yield Finding(behind, "nothing", f"the space behind {name}", f"give {behind}")
