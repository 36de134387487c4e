"""The study that chose the default recipe: every numerical choice against shock states, hole, crater and cost.

``python -m studies.recipe_study DIRECTORY`` computes what is missing and writes ``results.json``; with the extra
``figures`` installed it also draws. The page of conclusions is docs/recipe.md. The rule of the choice was written
before the study ran, by someone who had seen nine holes (linear and spline at both speeds and grids, one of GIMP):

1. A variant is out if a run of it fails, if the energy audit drifts by more than 1 %, or if single particles run away
   (the flag of the runs).
2. Of the rest, those are eligible that hold the plateau pressure of a plate impact within 1.5 % and the shock speed
   within 1 % at 2 and at 6 km/s.
3. Among these the smallest sum of |D(8) - D(4)| / D(8) over both speeds wins, where D(n) is the hole at n cells through
   the plate; variants within half a percentage point of the best count as equal, and then the cheaper one wins.

Variants change one thing at a time around a base of each shape.
"""
