"""A sweep with all its runs as the store writes them: small enough to go from one process to another."""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pydantic import JsonValue

    from studies.quantities.parameters import Plain
    from studies.runs.run import Run
    from studies.sweeps.sweep import Point, Sweep


class ExpandedPoint(NamedTuple):
    """A point with its run; the texts are JSON."""

    run_id: str
    scenario: str
    axis_index: str  # place on each axis
    coordinates: str
    # Specification of the run; None: an earlier point has the same run.
    parameters: str | None
    materials: str  # one object for all runs of the same materials
    cost: float  # core seconds of the run; 0 without parameters

    @property
    def spec(self) -> str:
        """The complete specification of the run, as ``Run.as_json`` gives it."""
        scenario = json.dumps(self.scenario)
        return f'{{"scenario": {scenario}, "parameters": {self.parameters}, "materials": {self.materials}}}'


@dataclass(frozen=True)
class ExpandedSweep:
    """A checked sweep and its points."""

    name: str
    title: str
    scenario: str
    document: "Mapping[str, JsonValue]"  # canonical
    points: tuple[ExpandedPoint, ...]
    memory: int = 0  # bytes that its largest run needs, estimated
    bytes: int = 0  # of the files of all runs, estimated
    warnings: tuple[str, ...] = ()  # doubts about its points and constants

    @property
    def digest(self) -> str:
        """Digest of the document and of the runs: the same document for the same physics."""
        text = json.dumps([self.document, [point.run_id for point in self.points]], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def core_seconds(run: "Run") -> float:
    """The estimated cost of a run, by modules that the API process need not load."""
    from studies.runs.run import estimate

    return estimate(run).core_seconds


def expand(sweep: "Sweep", cost: Callable[["Run"], float] = core_seconds) -> ExpandedSweep:
    """A sweep with all its runs; ``cost`` gives core seconds. Raises InvalidInput naming the refused points."""
    return ExpandedSweep(
        name=sweep.name,
        title=sweep.title or sweep.name,
        scenario=sweep.scenario,
        document=sweep.document(),
        points=tuple(expanded_points(sweep.every_run(), cost)),
    )


def expand_again(document: "Mapping[str, Plain]") -> ExpandedSweep:
    """An accepted sweep with its runs of this version, under the limits of its time; raises InvalidInput."""
    from studies.sweeps.reading import ACCEPTED
    from studies.sweeps.sweep import Sweep

    return expand(Sweep.parse(document, ACCEPTED))


def expanded_points(
    points: "Iterable[Point]", cost: Callable[["Run"], float] = core_seconds
) -> Iterator[ExpandedPoint]:
    """Each point as the store writes it."""
    seen: set[str] = set()
    texts: dict[str, str] = {}
    for point in points:
        run = point.run
        plain = run.as_json()
        materials = json.dumps(plain["materials"])
        is_new = run.id not in seen
        seen.add(run.id)
        yield ExpandedPoint(
            run_id=run.id,
            scenario=run.scenario,
            axis_index=json.dumps(point.index),
            coordinates=json.dumps(dict(point.coordinates)),
            parameters=json.dumps(plain["parameters"]) if is_new else None,
            materials=texts.setdefault(materials, materials),
            cost=cost(run) if is_new else 0.0,
        )
