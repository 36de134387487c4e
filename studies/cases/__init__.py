"""Cases: problems with a known answer, computed here and compared row by row.

``verification`` holds problems with an exact answer, ``validation`` published ones; in both folders one file adds one.
``rows`` is the record of a compared figure, ``compared`` makes rows of a cube, ``pages`` writes what was compared.
``solutions`` are the exact answers, ``setups`` the problems that several cases share.
"""
