"""The study that chose the default recipe: every numerical choice against exact answers, hole, crater and cost.

``python -m docs.recipe_study DIRECTORY`` computes it. The rule of the choice stands in docs/recipe.md alone;
``variants.py`` has what is varied, ``measure.py`` what is measured, ``choice.py`` the rule as code, ``figures.py`` the
drawings.
"""
