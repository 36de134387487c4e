"""What is said of speed: cost beside the former step, beside MPM3D-F90, and that the answers are the same."""
