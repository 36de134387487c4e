"""Laws over HTTP: asked about a shot, they answer at once."""

import io
import time

import pytest
import xarray as xr

from service.api.routes.catalogue import QUESTION
from tests.claims.marked import Compared
from tests.claims.rows import at_most
from tests.service.support.api import Api

ANSWER = 0.05  # s


def test_laws__answer_as_json_and_as_a_cube(shared_api: Api) -> None:
    answer = shared_api.http.post("/v1/laws/evaluate", json=QUESTION).json()
    assert answer["target"] == "shield"
    assert [len(item["quantities"]) for item in answer["items"]] == [2, 2]
    response = shared_api.http.post("/v1/laws/evaluate", json=QUESTION, headers={"Accept": "application/x-netcdf"})
    assert response.headers["Content-Type"] == "application/x-netcdf"
    with xr.open_dataset(io.BytesIO(response.content)) as cube:
        values = cube.critical_diameter.sel(law_of_critical_diameter="whipple_nno").values.tolist()
    said = [law for item in answer["items"] for law in item["quantities"][0]["laws"] if law["law"] == "whipple_nno"]
    assert values == pytest.approx([each["value"] for each in said])


def test_laws__refuse_with_field_value_limit_and_cure(shared_api: Api) -> None:
    response = shared_api.http.post("/v1/laws/evaluate", json={**QUESTION, "speed": "60 km/s"})
    assert response.status_code == 422
    [error] = response.json()["errors"]
    assert (error["field"], error["value"]) == ("speed", "'60 km/s'")


@pytest.mark.claim("door", "answer-time", minutes=0.2)
def test_laws__answer_within_fifty_milliseconds(shared_api: Api, compared: Compared) -> None:
    """A running service answers a question about one shield within 50 ms, the median of twenty."""

    def seconds(speed: int) -> float:
        begin = time.perf_counter()
        assert shared_api.http.post("/v1/laws/evaluate", json={**QUESTION, "speed": f"{speed} m/s"}).status_code == 200
        return time.perf_counter() - begin

    seconds(3000)
    compared(at_most("median time of an answer (s)", limit=ANSWER, got=sorted(map(seconds, range(3001, 3021)))[10]))
