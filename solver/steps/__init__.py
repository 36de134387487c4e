"""What the steps of all methods share: their interface, threads, space and update of points, and the stable step."""
