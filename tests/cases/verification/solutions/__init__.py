"""Exact answers: written from the equations alone, without the code of the solver, with their own doctests."""
