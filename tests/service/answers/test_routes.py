"""Laws over HTTP, asked about a shot."""

import io

import pytest
import xarray as xr

from service.answers.schemas import answer_model
from studies.answers import examples
from studies.quantities.parameters import Plain
from studies.sweeps.document import read_yaml
from tests.service.support.api import Api

QUESTION = {
    "speed": ["3 km/s", "6 km/s"],
    "projectile": "al-2017-t4",
    "projectile_diameter": "5 mm",
    "target": "al-6061-t6",
    "plate_thickness": "1.2 mm",
}


@pytest.mark.parametrize("question", [QUESTION, *(read_yaml(file.read_text(), file.name) for file in examples())])
def test_answer__has_the_fields_that_openapi_describes_and_no_more(shared_api: Api, question: dict[str, Plain]) -> None:
    answer = shared_api.http.post("/v1/laws/evaluate", json=question).json()
    assert answer_model().model_validate(answer).model_dump(mode="json") == answer


def test_laws__answer_as_json_and_as_a_cube(shared_api: Api) -> None:
    answer = shared_api.http.post("/v1/laws/evaluate", json=QUESTION).json()
    assert answer["target"] == "plate"
    response = shared_api.http.post("/v1/laws/evaluate", json=QUESTION, headers={"Accept": "application/x-netcdf"})
    assert response.headers["Content-Type"] == "application/x-netcdf"
    with xr.open_dataset(io.BytesIO(response.content)) as cube:
        values = cube.hole_diameter_by_law.sel(hole_diameter_law="maiden_al").values.tolist()
    said = [law for item in answer["items"] for law in item["quantities"][0]["laws"] if law["law"] == "maiden_al"]
    assert values == pytest.approx([law["value"] for law in said])
