"""The figure of the ballistic limit of a shield: diameter against speed, equations, and shots on shields like it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import xarray as xr

from studies import laws
from studies.answers.picture import SPEED, curves_of
from studies.cubes.points import Place
from studies.quantities.measured import flags_in_words
from studies.quantities.units import readable
from studies.reports.figure import INTERVAL, RUN_HELD, RUN_PERFORATED, RUN_UNDECIDED, Figure, Panel, Scale, Series
from studies.reports.view import MOST_PANELS, spread, title_of
from studies.reports.wording import in_words, text_template
from studies.shields.limit import name_of, shots_at
from studies.shields.picture import outcomes_of
from studies.shields.section import ShieldLimit
from studies.shields.shield import CRITICAL_DIAMETER, ShotAtShield
from studies.shields.shots.table import LIKE, like_shields, published

RUNS = {RUN_HELD: False, RUN_PERFORATED: True, RUN_UNDECIDED: None}


def shield_figure(
    dataset: xr.Dataset, limits: Sequence[ShieldLimit], every: Sequence[tuple[Place, ShotAtShield]]
) -> Iterator[Figure]:
    """The critical diameter over the speed, a panel for each shield."""
    shields: dict[tuple[float | str, ...], list[ShieldLimit]] = {}
    for limit in limits:
        shields.setdefault(tuple(limit.at.values()), []).append(limit)
    shown = spread(list(shields.values()), MOST_PANELS)
    shots = [next(iter(shots_at(every, mine[0].at)), None) for mine in shown]
    yield Figure(
        name="ballistic_limit",
        title="Ballistic limit of the shield: diameter of the projectile against speed",
        caption=_caption(len(shields) > len(shown), [shot for shot in shots if shot]),
        x=SPEED,
        y=Scale(CRITICAL_DIAMETER, "diameter of the projectile", "m"),
        panels=tuple(_panel(dataset, mine, shot) for mine, shot in zip(shown, shots, strict=True)),
    )


def _panel(dataset: xr.Dataset, limits: Sequence[ShieldLimit], shot: ShotAtShield | None) -> Panel:
    at = limits[0].at
    names = {law.title: name_of(law.name, law.title) for law in laws.answering(CRITICAL_DIAMETER)}
    curves = [replace(curve, label=names[curve.label]) for curve in curves_of(CRITICAL_DIAMETER, shot)] if shot else []
    series = [*curves, *outcomes_of(like_shields(shot))] if shot else []
    known = [(limit.speed, limit.lower, limit.upper) for limit in limits if limit.lower and limit.upper]
    if known:
        speeds, low, high = zip(*known, strict=True)
        inside = (True,) * len(known)
        series.append(Series("band", INTERVAL, speeds, low=low, high=high, in_range=inside, connected=False))
    why = text_template("studies.shields:why.txt")
    for label, perforated in RUNS.items():
        runs = [(limit.speed, run) for limit in limits for run in limit.runs if run.perforated is perforated]
        if runs:
            speeds, those = zip(*runs, strict=True)
            sizes, notes = tuple(run.diameter for run in those), tuple(in_words(why, run=run) for run in those)
            doubts = tuple(", ".join(flags_in_words(run.flags)) for run in those)
            series.append(Series("run", label, speeds, sizes, doubts=doubts, notes=notes, connected=False))
    return Panel(title_of(dataset, at), at, tuple(series))


def _caption(is_cut: bool, shots: Sequence[ShotAtShield]) -> str:
    stresses = [shot.shield.wall_yield_stress for shot in shots]
    known = dict.fromkeys("unknown" if math.isnan(stress) else readable(stress, "Pa") for stress in stresses)
    sentences = [
        "Squares: runs, filled where the wall is perforated. A bar reaches from the largest projectile that is held to "
        "the smallest that perforates."
    ]
    if known:
        sentences.append(
            f"Lines: equations, dotted outside their range; yield stress of the wall: {', '.join(known)}. Circles: "
            f"those of {len(published().shots)} published shots that are on shields like this one, at any speed: each "
            f"size, density and yield stress within a factor of {math.exp(LIKE):.1f} if all else is equal."
        )
    if is_cut:
        sentences.append("The cube contains the shields that are not drawn.")
    return " ".join(sentences)
