"""Whipple shields in reports: the ballistic limit beside equations, shots and the probability to fail."""
