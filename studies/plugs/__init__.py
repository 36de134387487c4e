"""Plugs in reports: residual velocities, with the curve of Recht and Ipson."""
