"""Fitting: ``forms`` of laws, the least squares that find their constants, and ``fitted`` laws for the next sweep."""
