"""What the project says about itself, recomputed: ``make claims``.

A claim is a sentence with a test that computes the answer anew, with the project's own code, and compares it with exact
or published numbers; it never reads an answer that an earlier run stored. ``tests.claims.marked`` says how a test
becomes one. A figure with ``passed=None`` is reported and not gated.

::

    make claims house                    # a set, or a claim; or: python -m tests.claims house
    python -m tests.claims --list

Without a name, all run. The exit status is 0 when nothing failed, 1 when something did, and 2 when no claim has the
name: an empty selection proves nothing.
"""
