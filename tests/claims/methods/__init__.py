"""Damage, and the methods that compute a scenario."""

from studies import verification

# Each verification case of the other methods is a claim by its own sentence.
ALSO = [*(name for name in verification.names() if name.startswith("sph-")), "finite-elements", "coupled-bar"]
