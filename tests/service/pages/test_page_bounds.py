"""Pages of 1 000 sweeps, one of them of nearly 10 000 runs: bytes and statements are bounded."""

import re
import time

import pytest
import sqlalchemy as sa

from service.records.jobs import Kind, State, Submission
from service.store import Store
from service.store.submission import accept
from service.store.tables import JOBS, now
from tests.claims.marked import Compared
from tests.claims.rows import at_most, equal
from tests.service.support.api import LARGE_SWEEPS, SWEEP, Api
from tests.service.support.fakes import runs_of, sweep_of
from tests.service.support.rows import statements

SWEEPS, COMPUTED = 1000, 450  # a grid shows 400 runs at once
MOST_BYTES = 120_000  # of a page
MOST_STATEMENTS = 8  # to make one, that of its transaction aside
LISTED, LIST_SECONDS = 500, 0.3
CELLS = re.compile(r'<td class="(\w+)[ "]')
LINK = 'class="sweep"><a href="/sweeps/'
MEASURED = {"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 1e-4, "flags": []}}}


def _fill(store: Store) -> str:
    """Let the first runs of a store have results, and add sweeps, in one transaction; a run with a result."""
    chosen = sa.select(JOBS.c.id).where(JOBS.c.kind == Kind.RUN).order_by(JOBS.c.ordinal).limit(COMPUTED)
    with store.database.writing() as connection:
        end = JOBS.update().where(JOBS.c.id.in_(chosen)).values(state=State.SUCCEEDED, summary=MEASURED)
        run = connection.execute(end.returning(JOBS.c.id)).scalars().all()[0]
        for number in range(SWEEPS - 1):
            sweep = sweep_of(runs_of("fine", first=number), name=f"sweep {number}")
            accept(connection, Submission(sweep), sweep, now())
    return str(run)


@pytest.mark.claim("pages", "bounds", minutes=0.5)
def test_pages__of_many_sweeps_and_runs_are_bounded(api: Api, compared: Compared) -> None:
    """With 1 000 sweeps, one of 9 990 runs, every page takes at most 8 statements and 120 kB."""
    answer = api.http.post("/v1/sweeps", json=LARGE_SWEEPS["a grid of 999 x 10"])
    assert answer.status_code == 202, answer.text
    large = answer.json()["id"]
    run = _fill(api.store)
    pages = {
        "sweeps": "/",
        "sweeps that are searched": "/?q=sweep+99&state=queued&own=true",
        "large sweep": f"/sweeps/{large}",
        "its last rows": f"/sweeps/{large}?row=990",
        "a run of it": f"/runs/{run}",
    }
    found = {}
    for name, address in pages.items():
        with statements(api.store) as sent:
            response = api.http.get(address)
        assert response.status_code == 200, response.text
        found[name] = response.text
        compared(at_most(f"{name}: bytes", limit=MOST_BYTES, got=len(response.content)))
        asked = [text for text in sent if not text.startswith("BEGIN")]
        compared(at_most(f"{name}: statements", limit=MOST_STATEMENTS, got=len(asked)))
    cells = CELLS.findall(found["large sweep"])
    shown = len(cells), "succeeded" in cells
    compared(equal("runs in the grid, of which some have succeeded", expected=(400, True), got=shown))
    compared(equal("sweeps on the first page", expected=50, got=found["sweeps"].count(LINK)))
    named = sum("99" in str(number) for number in range(SWEEPS - 1))
    compared(equal("sweeps that were found", expected=named, got=found["sweeps that are searched"].count(LINK)))


@pytest.mark.claim("contract", "list-of-500", minutes=0.5)
def test_list__of_500_sweeps_is_quick(api: Api, compared: Compared) -> None:
    """A list of 500 sweeps with headline and thumbnail, all on one page, is there in 0.3 s: the median of five."""
    for number in range(LISTED):
        axes = {"speed": ["6 km/s", f"{3.0 + 1e-3 * number:.3f} km/s"]}
        assert (
            api.http.post("/v1/sweeps", json={**SWEEP, "title": f"sweep {number // 2}", "axes": axes}).status_code
            == 202
        )
    api.compute()
    taken = []
    for _ in range(5):
        begin = time.perf_counter()
        text = api.http.get(f"/?show={LISTED}").text
        taken.append(time.perf_counter() - begin)
    compared(equal("thumbnails", expected=LISTED, got=text.count("cover/thumbnail")))
    compared(at_most("time (s)", limit=LIST_SECONDS, got=sorted(taken)[2]))
