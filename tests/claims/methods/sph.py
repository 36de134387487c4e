"""Smoothed particles against exact answers: each verification case is a claim by its own sentence."""

from tests.claims.proven.cases import claims_of

CLAIMS = claims_of(smoothed=True)
