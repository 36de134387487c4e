"""The root of a function between two ends: importing scipy.optimize takes longer than a whole answer about a shield."""

from collections.abc import Callable


def root_between(function: Callable[[float], float], low: float, high: float, *, within: float) -> float:
    """Where a function changes its sign between two ends, at which its signs differ; to ``within`` of the argument.

    Chandrupatla (1997), Adv. Eng. Softw. 28, 145: inverse quadratic interpolation where the last three points allow it,
    else bisection. ``last`` is the newest end of the bracket, ``other`` the end across the root, ``third`` the end that
    was left.

    >>> round(root_between(lambda x: x**3 - 2.0, 0.0, 2.0, within=1e-9), 9)
    1.25992105
    """
    other, last, share = low, high, 0.5
    at_other, at_last = function(other), function(last)
    while True:
        point = last + share * (other - last)
        value = function(point)
        if (value > 0.0) == (at_last > 0.0):
            third, at_third = last, at_last
        else:
            third, at_third, other, at_other = other, at_other, last, at_last
        last, at_last = point, value
        least = 0.5 * within / abs(other - last) if other != last else 1.0
        if least > 0.5 or at_last == 0.0:
            return last if abs(at_last) < abs(at_other) else other
        place, height = (last - other) / (third - other), (at_last - at_other) / (at_third - at_other)
        share = 0.5
        if height**2 < place and (1.0 - height) ** 2 < 1.0 - place:
            slope = (third - last) / (other - last) * at_last / (at_third - at_last) * at_other / (at_third - at_other)
            share = at_last / (at_other - at_last) * at_third / (at_other - at_third) + slope
        share = min(max(share, least), 1.0 - least)
