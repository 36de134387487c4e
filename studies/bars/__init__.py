"""Bars that hit a rigid wall: their scenarios, loads and measurements."""
