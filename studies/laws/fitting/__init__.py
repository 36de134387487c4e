"""Fitting: the least squares that find the constants of laws, their intervals, and what compares fits."""
