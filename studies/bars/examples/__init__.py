"""Sweeps of bars that ship."""
