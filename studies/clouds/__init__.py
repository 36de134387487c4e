"""Debris clouds in reports: the sizes of their fragments."""
