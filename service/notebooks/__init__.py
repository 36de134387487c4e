"""What notebooks show: sweeps as tables, the folder of a computed one, moving pictures."""
