"""Matter: the models of a body's matter, and the stress update of a point, without geometry and kernels."""
