"""The bumpers of a shield behind its first one: parameters by their place, and the list that a document has of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

from solver.units import Described, Metre
from studies.quantities.findings import Finding, InvalidInput, refusal, unknown_keys
from studies.quantities.parameters import MaterialName, Places
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


@dataclass(frozen=True, kw_only=True)
class Bumper:
    """A bumper behind the first one, which is there where it has a thickness."""

    bumper: Annotated[MaterialName | None, Described("material of {place}")] = None
    thickness: Annotated[Metre | None, Described("thickness of {place}, 0 for none", 0.0, 1.0)] = None
    stand_off: Annotated[Metre | None, Described("space behind {place}", 1e-4, 10.0)] = None


@dataclass(frozen=True, kw_only=True)
class FurtherBumpers:
    """The bumpers behind the first one, the outermost first."""

    bumpers: Annotated[tuple[Bumper, ...], Places(BUMPERS[1:], "bumper")] = ()

    def filled(self) -> Self:
        """Without those at the end that have no thickness."""
        count = max((place for place, each in enumerate(self.bumpers, 1) if each.thickness), default=0)
        return replace(self, bumpers=self.bumpers[:count])

    def check(self) -> Iterator[Finding]:
        """A bumper has a space behind it and another one in front of it."""
        for place, bumper in enumerate(self.bumpers, 1):
            name, before = BUMPERS[place], BUMPERS[place - 1]
            if not bumper.thickness:
                continue
            if not all(each.thickness for each in self.bumpers[:place]):
                value, limit = readable(bumper.thickness, "m"), f"0 m without {before}"
                yield Finding(f"{name}_thickness", value, limit, f"give {before}_thickness")
            elif bumper.stand_off is None:
                behind = f"{name}_stand_off"
                yield Finding(behind, "nothing", f"the space behind {name}", f"give {behind}")
