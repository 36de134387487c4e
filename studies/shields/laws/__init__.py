"""Equations of the ballistic limit: the diameter of a projectile above which a Whipple shield fails."""
