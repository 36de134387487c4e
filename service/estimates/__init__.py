"""The cost of a sweep before it is computed: ``whipple estimate``, and ``/v1/sweeps/estimate``."""
