"""Everything that a report shows as a picture, drawn by Matplotlib: inside of the page as SVG, and as files for print.

``canvas`` has the common style and turns a drawing into SVG or a file; ``charts`` draws a figure
(:mod:`studies.reports.figures`) with ``layout``, ``marks`` and ``styles``; ``sections`` draws sections of runs
(:mod:`studies.reports.picture`) from ``pixels``.
"""
