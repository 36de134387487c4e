"""Films of runs: recorded while a run is solved (``film``), read as a dataset over time and particle, exported to VTK,
drawn as moving pictures; and what screens draw of a run (``views``).
"""
