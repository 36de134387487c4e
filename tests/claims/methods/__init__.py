"""Damage, and the methods that compute a scenario."""
