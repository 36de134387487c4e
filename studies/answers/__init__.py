"""What published laws and measured shots say of a plate, a block or a shield, without a run.

``question`` reads what is asked, with values along axes where a parameter has several; ``answer`` asks every law about
each of its shots, and finds the published shots nearest to one; ``cube`` has the same numbers as a dataset. The
service, the command line (``whipple laws --at``) and ``whipple.laws`` ask here, and none of them loads the solver.
"""

from importlib.resources import files

EXAMPLE = files(__package__).joinpath("shield.yaml")  # a question that ships, which ``make demo`` asks first
