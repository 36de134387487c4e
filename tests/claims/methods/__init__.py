"""Damage, and the methods that compute a scenario."""

from studies import verification

# Each verification case of smoothed particles is a claim by its own sentence.
ALSO = [name for name in verification.names() if name.startswith("sph-")]
