"""What holes, craters, debris and plugs of an impact share: the view (``view``), edges of matter (``edges``), openings.

``view`` makes the view of holes and craters of a snapshot; ``opening`` has sizes by radii in sectors of azimuth.
"""
