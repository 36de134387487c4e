"""What operators of a service do: keys, the trail of orders, checks, backup, retention, results measured again.

``commands`` and ``keys`` are the commands, ``offline`` opens the store for them, and ``audit`` writes down the orders
that come over HTTP.
"""
