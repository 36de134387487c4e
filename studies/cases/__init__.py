"""Published problems, computed here and compared figure by figure: ``whipple validate``.

``validation`` holds them, and one file adds one. ``compared`` makes comparisons of a cube, ``pages`` writes what was
compared.
"""
