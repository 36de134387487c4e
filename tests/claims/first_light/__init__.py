"""First light: hole and crater sweeps on real physics."""
