"""Sweeps of plate impacts that ship."""
