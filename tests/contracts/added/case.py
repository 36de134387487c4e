"""The bulk modulus of an added equation of state is its slope at rest."""

from solver.registry import entries
from studies.cases.rows import relative
from studies.cases.verification import VerificationCase


def _run(recipe):
    from solver.matter.eos import pressure_terms

    record = entries("solver.matter.eos", "EOS")["murnaghan"].record
    eos = record(density=8930.0, K=140e9, n=4.0, heat_capacity=383.0, temperature=293.0)
    pressure, _ = pressure_terms(eos, 8930.0 * (1.0 + 1e-6), 0.0)
    yield relative("bulk modulus (Pa)", expected=140e9, got=pressure / 1e-6, within=1e-5)


CASE = VerificationCase("murnaghan", "Bulk modulus", "Murnaghan (1944)", _run)
