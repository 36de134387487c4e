"""What the queue says about itself: nothing that was accepted is lost, whatever dies.

Each claim has a short form, which the test command runs (tests/acceptance), and the full form here.
``WHIPPLE_SEED`` chooses what is killed when; ``make soak`` draws it.
"""
