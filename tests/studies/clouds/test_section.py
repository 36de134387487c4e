"""The section of fragments, and what the report withholds of them."""

import math
import re
from collections.abc import Callable

import pytest

from studies.clouds.fragments import OF_PIECES, SIZES
from studies.cubes import cube
from studies.quantities.measured import COARSER_THAN_FRAGMENTS
from studies.reports.compare import compare
from studies.reports.opening import opening_of
from studies.runs.results import ReadDistribution, RunResult
from studies.sweeps.axes import Axis
from tests.claims.rows import Row, equal
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of
from tests.studies.support.printed import undrawn_page


@pytest.mark.claim("breaking", "withheld")
def test_report__withholds_numbers_of_pieces_that_the_mesh_made(compared: Callable[[Row], None]) -> None:
    """A number of pieces that the mesh alone made is in no headline and no list of values; the page says so."""
    sweep = sweep_of(Axis("speed", "m s-1", (4e3, 6e3)), scenario="debris_cloud", fixed={"plate_thickness": 4e-3})
    sizes: list[float | list[float]] = [5.0 if 20 <= size < 24 else 0.0 for size in range(SIZES.count)]
    outcomes = {}
    for point in sweep.runs():
        is_fast = point.run.parameters["speed"] == 6e3
        values = {
            "fragments": fakes.measured(777.0 if is_fast else 20.0, *((COARSER_THAN_FRAGMENTS,) if is_fast else ())),
            "fragment_size_grady": fakes.measured(3e-4),
        }
        over_size = {one.name: ReadDistribution(version=1, values=sizes) for one in OF_PIECES}
        outcomes[point.run.id] = RunResult(
            point.run.id,
            "succeeded",
            measurements=values,
            numbers={"cells_per_diameter": fakes.UNREFINED},
            provenance=fakes.PROVENANCE,
            distributions=over_size,
        )
    dataset = cube.build(sweep, outcomes)
    comparison = compare(dataset)
    opening = opening_of(comparison.points, comparison.judgements, comparison.shots)
    assert opening is not None
    opened = {value.value for each in opening.quantities for value in each.values}
    compared(equal("values that may open the report", expected={20.0, 3e-4}, got=opened))
    document = fakes.document_of(dataset)
    (fragments,) = (each for each in document["values"]["ranges"] if each["quantity"] == "fragments")
    ends = [fragments["smallest"], fragments["largest"]]
    compared(equal("smallest and largest number of fragments", expected=[20.0, 20.0], got=ends))
    withheld = [{"quantity": "fragments", "points": 1, "of": 2}]
    compared(equal("withheld", expected=withheld, got=document["values"]["withheld"]))
    text = re.sub(r"<[^>]+>", "", undrawn_page(document))
    compared(equal("the page says so", expected=1, got=text.count("Fragments: no answer at 1 of 2 points. A cell of")))
    (figure,) = (each for each in document["figures"] if each["name"] == "fragment_sizes")
    marks = {series["label"]: series["x"][0] for series in figure["panels"][0]["series"][-2:]}
    expected = {
        "a cell of the mesh": math.log10(1.0 / fakes.UNREFINED),
        "fragments after Grady": math.log10(3e-4 / fakes.DIAMETER),
    }
    compared(equal("marks in the figure of sizes", expected=expected, got=marks))
    number = figure["panels"][0]["series"][0]["y"]
    compared(equal("shares that are larger", expected=[1.0, 1.0, 0.75, 0.5, 0.25, 0.0], got=number))
