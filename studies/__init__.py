"""Questions and answers: scenarios, sweeps, measurements, laws, cubes, reports, validation cases."""
