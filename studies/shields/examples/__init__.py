"""Sweeps of shields that ship."""
