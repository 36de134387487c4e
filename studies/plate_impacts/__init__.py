"""Plates that hit plates, face to face: their scenario and measurements."""
