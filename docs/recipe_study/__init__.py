"""The study that chose the default recipe: every numerical choice against exact answers, hole, crater and cost.

``python -m docs.recipe_study DIRECTORY`` computes what is missing and writes ``results.json``; with the extra
``figures`` installed it also draws. The page of conclusions is docs/recipe.md. The rule:

1. A variant is out if a run of it fails, if the energy audit drifts by more than 1 %, or if single particles run away
   (the flag of the runs).
2. Of the rest, those are eligible that hold every gate of four problems with known answers: plate impact at all
   speeds and pairs of materials (pressure 1.5 % for splines, 2 % for other shapes; shock speed 1 %; densities 0.5 %),
   the elastic bar on a wall (time in contact 3 %, rebound 0.93), the Taylor bar on the thesis' grid (0.015), Noh's
   implosions (plane: front 3 %, plateau 5 %; axis: front 8 %).
3. Of each smooth shape with 2 and with 3 particles along a cell, the candidate is the eligible pair of linear and
   quadratic viscosity whose pressure scatters least behind the shocks. The other choices stay those of the base; their
   variants show what they would give and cost.
4. Candidates are asked for the hole at 4, 8 and 16 cells through the plate, mean of three sub-cell positions, at 2, 4
   and 6 km/s, the cheapest candidate (by a hole at 4 cells) first: from 4 to 8 cells it may change by 8 %, from 8 to 16
   by 2 %. The first that holds is the default. In short: the cheapest recipe that holds every gate.

The gates are the specification of the project, older than any run; the rule around them is younger than many figures,
and docs/recipe.md says which.

Variants change one thing at a time around a base of each shape.
"""
