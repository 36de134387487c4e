"""Shots on Whipple shields: outcomes of the wall, published or the user's own, and what they say about a shield.

``shots`` reads, screens and finds them; ``judged`` counts how often each equation was right; ``probability`` makes of
the margins of the equations the probability that the wall fails, and ``joined`` joins it with a simulation;
``answers`` has all of that for a designer's shield.
"""
