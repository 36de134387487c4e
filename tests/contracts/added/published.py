"""All of an added plate is attached, by a published number."""

from studies.cases.validation import ValidationCase
from studies.quantities.comparison import absolute


def _rows(level, cubes):
    got = float(cubes["added"].attached_share.min())
    yield absolute("attached share", expected=1.0, got=got, within=0.0)


CASE = ValidationCase(name="attached", says="A plate stays", source="-", sweeps=lambda level: {}, rows=_rows)
