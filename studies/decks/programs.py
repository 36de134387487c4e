"""Input files of other programs, told by the words that they begin with."""

import re
from collections.abc import Mapping

from studies.quantities.findings import Finding, InvalidInput

OWN = "whipple reads decks of MPM3D"
MOST_LINES = 100  # that are looked at, without empty lines
LONGEST_LINE = 200  # characters of a line that are looked at

# Each matches the beginning of a line that no deck of MPM3D has. Abaqus after LS-DYNA, which has keywords of its own.
SIGNATURES: Mapping[str, str] = {
    "an LS-DYNA keyword file": r"\*(KEYWORD\b|(PART|SECTION|MAT|CONTROL|ELEMENT|DATABASE|EOS|INITIAL)_[A-Z_]+)",
    "an Abaqus input file": r"\*(HEADING|NODE|ELEMENT|PART|MATERIAL|STEP|ASSEMBLY|INCLUDE|PREPRINT)\b(,|\s*$)",
    "an input file of CTH": r"\*eor\*",
    "a Nastran bulk data file": r"(BEGIN +BULK|SOL +\d+|CEND)\b",
    "a Radioss starter file": r"#RADIOSS\b|/BEGIN\b",
    "an Ansys input file": r"/(PREP7|BATCH|COM\b|FILNAME)",
    "an input file of Autodyn": r"\W*AUTODYN\b",
    "an input file of LAMMPS": r"(atom_style|pair_style|units +(lj|real|metal|si|cgs))\b",
    "an input file of iSALE": r"#ISINP\b",
    "a mesh of Gmsh": r"\$MeshFormat",
    "a VTK file": r"# vtk DataFile|<VTKFile",
}
_PROGRAMS = [(program, re.compile(signature, re.IGNORECASE)) for program, signature in SIGNATURES.items()]


def check_program(text: str) -> None:
    """Raise InvalidInput for the beginning of a file of another program, named."""
    lines = [line.strip()[:LONGEST_LINE] for line in text[: MOST_LINES * LONGEST_LINE].splitlines()]
    for line in [line for line in lines if line][:MOST_LINES]:
        if line.lower().startswith("mpm3"):
            return
        program = next((program for program, signature in _PROGRAMS if signature.match(line)), None)
        if program is not None:
            cure = "write the problem as a deck of MPM3D, or as a scenario: docs/decks.md"
            raise InvalidInput([Finding("deck", program, OWN, cure)])
