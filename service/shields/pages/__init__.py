"""The pages of shields and of the shots at them, and what pages of runs and sweeps say beside walls that hold."""
