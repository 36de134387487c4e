"""Outcomes in reports: what happened in each shot, whichever way it is computed, or what leaves it open."""
