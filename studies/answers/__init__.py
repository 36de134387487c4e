"""What published laws and measured shots say of a plate, a block or what features add, without a run.

``question`` reads what is asked, with values along axes where a parameter has several; ``answer`` asks every law about
each of its shots, and finds the published shots nearest to one; ``cube`` has the same numbers as a dataset; ``targets``
are what can be asked about. The service, the command line (``whipple laws --at``) and ``whipple.laws`` ask here, and
none of them loads the solver.
"""

from pathlib import Path

from studies.answers.targets import targets


def examples() -> list[Path]:
    """The questions that ship, which ``make demo`` asks first."""
    return [target.example for target in targets().values() if target.example]
