"""The figure of the ballistic limit of a shield: diameter against speed, equations, and shots on shields like it."""

import math
from collections.abc import Iterator, Sequence

import xarray as xr

from studies.laws import Shield, Shot
from studies.observations.shields.drawn import beside_held
from studies.observations.shields.shots import published
from studies.quantities.units import readable
from studies.reports.figure import INTERVAL, RUN_HELD, RUN_PERFORATED, RUN_UNDECIDED, Figure, Panel, Scale, Series
from studies.reports.limits.curves import LIKE, SPEED, curves_of, like_shields, outcomes_of
from studies.reports.limits.shield import DIAMETER, ShieldLimit, shot_at, shots_of
from studies.reports.view import MOST_PANELS, spread, title_of
from studies.reports.words import joined

RUNS = {RUN_HELD: False, RUN_PERFORATED: True, RUN_UNDECIDED: None}


def shield_figure(dataset: xr.Dataset, limits: Sequence[ShieldLimit]) -> Iterator[Figure]:
    """The critical diameter over the speed, a panel for each shield; none without a limit."""
    if not limits:
        return
    shields: dict[tuple[object, ...], list[ShieldLimit]] = {}
    for limit in limits:
        shields.setdefault(tuple(limit.at.values()), []).append(limit)
    shown = spread(list(shields.values()), MOST_PANELS)
    every = shots_of(dataset)
    shots = [shot_at(every, each[0].at) for each in shown]
    panels = (_panel(dataset, each, shot) for each, shot in zip(shown, shots, strict=True))
    yield Figure(
        name="ballistic_limit",
        title="Ballistic limit of the shield: diameter of the projectile against speed",
        caption=_caption(len(shields) - len(shown), [shot.shield for shot in shots if shot and shot.shield], limits),
        x=SPEED,
        y=Scale(DIAMETER, "diameter of the projectile", "m"),
        panels=tuple(panels),
    )


def _panel(dataset: xr.Dataset, limits: Sequence[ShieldLimit], shot: Shot | None) -> Panel:
    at, known = limits[0].at, [limit for limit in limits if limit.is_bracketed]
    series = [*curves_of(DIAMETER, shot), *outcomes_of(like_shields(shot))] if shot else []
    if known:
        speeds, inside = tuple(limit.speed for limit in known), (True,) * len(known)
        low, high = tuple(limit.lower for limit in known), tuple(limit.upper for limit in known)
        series.append(Series("band", INTERVAL, speeds, low=low, high=high, in_range=inside, connected=False))
    for label, perforated in RUNS.items():
        runs = [(limit.speed, run) for limit in limits for run in limit.runs if run.perforated is perforated]
        if runs:
            speeds, each = zip(*runs, strict=True)
            texts = [tuple(getattr(run, name) for run in each) for name in ("flags", "why")]
            sizes = tuple(run.diameter for run in each)
            series.append(Series("run", label, speeds, sizes, doubts=texts[0], notes=texts[1], connected=False))
    return Panel(title_of(dataset, at), at, tuple(series))


def _caption(left_out: int, shields: Sequence[Shield], limits: Sequence[ShieldLimit]) -> str:
    found = dict.fromkeys(beside_held(limit.found) for limit in limits if math.isfinite(limit.lower))
    sentences = [
        "Squares: runs, filled where the wall is perforated, open where it holds. A bar reaches from the largest "
        "projectile that is held to the smallest that perforates. Of a cylinder the diameter is that of the sphere "
        "with its volume."
    ]
    if found:
        sentences.append(f"Walls that hold: {'; '.join(found)}.")
    if shields:
        stresses = [each.wall_yield_stress for each in shields]
        known = joined(
            list(dict.fromkeys("unknown" if math.isnan(each) else readable(each, "Pa") for each in stresses))
        )
        sentences.append(
            "Lines: equations that cover the shield at some speed, dotted outside their range; yield stress of the "
            f"wall: {known}. Circles: those of {len(published().shots)} published shots that are on shields like "
            f"this one, unscaled and at any speed: the root of the summed squares of the ln ratios of bumper, wall, "
            f"space, densities and the wall's yield stress, and of the angle in rad, is at most {LIKE:g}."
        )
    if left_out:
        sentences.append("The cube contains the shields that are not drawn.")
    return " ".join(sentences)
