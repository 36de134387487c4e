"""What the project says about itself, recomputed: ``make claims``.

A claim is a sentence with a check. The check computes the answer anew, with the project's own code,
and compares it with published numbers; it never reads an answer that an earlier run stored.

How to add one
--------------
A verification case is a claim by itself. Else write a function in a module of a set,
``tests/claims/<set>/<anything>.py``; there is no list to edit. The set ``first_light`` is called
``first-light`` on the command line::

    from tests.claims import Row, claim, relative

    @claim("thesis-deck-2", says="MPM3D-F90's hole at 2 km/s is met at 0.5 mm cells")
    def thesis_deck_2():
        run = ...
        yield relative("hole diameter (mm)", expected=14.8, got=run.hole * 1e3, within=0.08)
        yield Row("the same at 1 mm cells", expected=15.3, got=coarse.hole * 1e3, passed=None)

It yields (or returns) one row or several, records of ``studies.verification``. ``passed=None``
makes a row that is reported and not gated. An exception is a FAIL with its text, and so is a claim
that yields nothing. ``quick=True`` puts a claim into the test command as well: for those of a few
seconds. A check that a test or a verification case makes already is called, not written again.

How to run them
---------------
::

    make claims first-light                    # or: python -m tests.claims first-light
    python -m tests.claims --list
    python -m tests.claims thesis-deck-hole --json claims.json

Without a name, all run. The exit status is 0 when nothing failed, 1 when something did, and 2
when no claim has the name: an empty selection proves nothing.
"""

from tests.claims.framework import Claim, claim
from tests.rows import Row, absolute, at_least, at_most, equal, relative

__all__ = ["Claim", "Row", "absolute", "at_least", "at_most", "claim", "equal", "relative"]
