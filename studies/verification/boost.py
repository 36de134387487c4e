"""The same plate impact seen from other frames: the grid rests in one of them only, the plateau must not care."""

from collections.abc import Iterator

from studies.values.recipes import Recipe
from studies.verification import Case, Row, relative
from studies.verification._collision import waves
from studies.verification._hugoniot import COPPER, shocked
from studies.verification.plate_impact import DENSITY, PRESSURE, SHOCK_SPEED, impact

SPEED = 4e3  # m/s
# Of the impact speed: the frame of the centre of mass, that of the flyer, and one that moves with neither.
BOOSTS = (0.0, -0.5, -1.0, 0.618)


def _run(recipe: Recipe) -> Iterator[Row]:
    exact = shocked(COPPER, 0.5 * SPEED)
    for part in BOOSTS:
        result = impact(COPPER, COPPER, SPEED, recipe, boost=part * SPEED)
        for body, wave in waves(result):
            where = f"Cu on Cu, {SPEED / 1e3:g} km/s, frame moved by {part:+g} v, {body}"
            gated = recipe.shape in PRESSURE
            yield relative(
                f"{where}: plateau pressure (GPa)",
                expected=exact.pressure / 1e9,
                got=wave.plateau.stress / 1e9,
                within=PRESSURE.get(recipe.shape),
            )
            yield relative(
                f"{where}: particle density (kg/m3)",
                expected=exact.density,
                got=wave.plateau.density,
                within=DENSITY if gated else None,
            )
            yield relative(
                f"{where}: internal energy (MJ/kg)",
                expected=exact.energy / 1e6,
                got=wave.plateau.energy / 1e6,
            )
            yield relative(
                f"{where}: shock speed (m/s)",
                expected=exact.shock_speed,
                got=wave.speed,
                within=SHOCK_SPEED if gated else None,
            )


CASE = Case(
    name="velocity-boost",
    says="the plateau of a plate impact does not care for the frame",
    source="Galilean invariance, which a grid keeps only approximately",
    run=_run,
)
