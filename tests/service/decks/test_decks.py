"""Decks of the size of MPM3D's own through every door: command line, REST and page."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from service.pages.pages.asking import ORDER, SUBMIT
from tests.claims.marked import Compared
from tests.claims.rows import at_most, equal
from tests.service.pages.test_login import token_on
from tests.service.support.api import Api, open_api
from tests.service.support.command import run
from tests.studies.decks.texts import points_deck

LARGE = points_deck(1_400_000)  # MPM3D-F90's Taylor has 1 387 604 bytes
SECONDS = 1.0  # of computing, until a refusal has been sent
REFUSED = {
    "an unknown macro at its end": (LARGE.replace("endi", "endx"), "a macro of MPM3D"),
    "a word in a late row": (LARGE[:-60].rpartition("\n")[0] + "\n x y\n", "a whole number"),
    "of LS-DYNA": (f"*KEYWORD\n{LARGE.partition(chr(10))[2]}", "an LS-DYNA keyword file"),
}


def document(deck: str, end: str) -> dict[str, Any]:
    return {"scenario": "deck", "fixed": {"deck": deck}, "axes": {"end_time": [end]}}


def by_rest(api: Api, deck: str) -> tuple[int, str]:
    sent = api.http.post("/v1/sweeps", json=document(deck, "1 us"))
    return sent.status_code, sent.text


def by_page(api: Api, deck: str) -> tuple[int, str]:
    html = {"Accept": "text/html"}
    fields = {
        ORDER: SUBMIT,
        "deck": deck,
        "end_time": "2 us",
        "csrf_token": token_on(api.http.get("/login", headers=html)),
    }
    sent = api.http.post("/new/deck", data=fields, headers=html, follow_redirects=False)
    return sent.status_code, sent.text


def by_command(capsys: pytest.CaptureFixture[str], file: Path, deck: str) -> tuple[int, str]:
    file.write_text(deck)
    status = run("deck", str(file))
    return status, "".join(capsys.readouterr())


@pytest.mark.claim("mend", "decks-of-mpm3d", minutes=0.5)
def test_decks__of_the_size_of_mpm3d_are_read_through_every_door(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], compared: Compared
) -> None:
    """Decks of 1.4 MB are read by command, REST and page, and a refused one is named within a second of computing."""
    with open_api(tmp_path / "data") as api:
        doors: dict[str, tuple[int, int, Callable[[str], tuple[int, str]]]] = {
            "command": (0, 2, lambda deck: by_command(capsys, tmp_path / "bar.mpm", deck)),
            "REST": (202, 422, lambda deck: by_rest(api, deck)),
            "page": (303, 422, lambda deck: by_page(api, deck)),
        }
        for door, (accepted, refused, send) in doors.items():
            compared(equal(f"{door}, a deck of {len(LARGE)} bytes: status", expected=accepted, got=send(LARGE)[0]))
            for name, (deck, words) in REFUSED.items():
                begin = time.process_time()
                status, text = send(f"{deck}\n! {door}")  # no deck that was read before
                seconds = time.process_time() - begin
                compared(equal(f"{door}, {name}: status, named", expected=(refused, True), got=(status, words in text)))
                compared(at_most(f"{door}, {name}: seconds of computing", limit=SECONDS, got=seconds))
