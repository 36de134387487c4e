"""A plate impact seen from several frames: the grid rests in one frame only, and the plateau must be the same."""

from collections.abc import Iterator

from studies.values.recipes import Recipe
from studies.verification import Case, Row, relatives
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
            got, pressure = wave.plateau, PRESSURE.get(recipe.shape)
            speed_error, density_error = (SHOCK_SPEED, DENSITY) if pressure else (None, None)
            yield from relatives(
                where,
                ("plateau pressure (GPa)", exact.pressure / 1e9, got.stress / 1e9, pressure),
                ("particle density (kg/m3)", exact.density, got.density, density_error),
                ("internal energy (MJ/kg)", exact.energy / 1e6, got.energy / 1e6, None),
                ("shock speed (m/s)", exact.shock_speed, wave.speed, speed_error),
            )


CASE = Case(
    name="velocity-boost",
    says="the plateau of a plate impact is the same in every frame",
    source="Galilean invariance, which a grid keeps only approximately",
    run=_run,
)
