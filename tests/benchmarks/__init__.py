"""How fast it is: numbers to read, never part of pass or fail."""
