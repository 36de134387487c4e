"""Reads stored final states again, in the process that then publishes the sweep; nothing is solved.

A new result lies beside the one that it takes the place of, in the folder of the same attempt, under
a name made of that one's digest and of the definitions that it was read by. It is written once and
never replaced: a process that begins again after a kill takes what is there, and two sweeps that share
a run share the file.
"""

import hashlib
import json
import os
import uuid
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from service.artifacts import describe, digest
from service.rereads import REREADS, Reread, Rereads, summary_of
from service.version import version
from studies.atomic import to_disk, write_text
from studies.files import ANSWER

Words = Mapping[str, Any]


class Unreadable(Exception):
    """A run whose stored state cannot be read again; its result stays as it was."""


def read_again(order: Words, directory: Path) -> dict[str, Words]:
    """New results (``RunResult.as_json``) of the runs of a sweep that its order names, by run id.

    Also leaves what the rows need to know of them, in the directory.
    """
    from studies.sweep import ACCEPTED, Sweep

    sweep = Sweep.parse(order["document"], ACCEPTED)
    runs = {point.run.id: point.run for point in sweep.runs()}
    places = {one["run_id"]: one for one in order["outcomes"]}
    read: dict[str, tuple[Reread, Words]] = {}
    unreadable: dict[str, str] = {}
    for id, state in order["again"].items():
        try:
            read[id] = _read(runs.get(id), places[id], state)
        except Exception as error:  # whatever it is, it touches this run alone
            unreadable[id] = f"{type(error).__name__}: {error}"
            print(f"{id} stays as it was: {unreadable[id]}")
    found = Rereads(tuple(reread for reread, _ in read.values()), unreadable)
    write_text(directory / REREADS, json.dumps(found.as_json()))
    return {id: answer for id, (_, answer) in read.items()}


def _read(run: Any, place: Words, state: Words) -> tuple[Reread, Words]:
    """A run's result, read again; raises whatever hinders that."""
    from studies.remeasure import definitions, remeasure
    from studies.results import RunResult

    if run is None:
        raise Unreadable("the sweep no longer has such a run: the physics has another version")
    file = Path(place["path"])
    for one, sha256 in ((file, place["sha256"]), (Path(state["path"]), state["sha256"])):
        if digest(one) != sha256:
            raise Unreadable(f"{one.name} does not match its checksum")
    written = _place_of(file, place["sha256"], definitions(run.scenario))
    if not written.is_file():
        before = RunResult.from_json(json.loads(file.read_bytes()))
        after = remeasure(run, before, Path(state["path"]), by=f"whipple {version()}")
        _write_once(written, json.dumps(after.as_json(), allow_nan=False, indent=1))
    answer = json.loads(written.read_bytes())
    stored = replace(describe(written), name=ANSWER)
    return Reread(place["run_id"], place["sha256"], stored, summary_of(answer)), answer


def _place_of(file: Path, sha256: str, versions: Mapping[str, int]) -> Path:
    """Where the result goes that is read again, by these definitions, from one with this digest."""
    question = json.dumps([sha256, sorted(versions.items())])
    return file.with_name(f"result-{hashlib.sha256(question.encode()).hexdigest()[:16]}.json")


def _write_once(file: Path, text: str) -> None:
    """Write a file that is not there yet, whole or not at all; one that is there is left alone."""
    draft = write_text(file.with_name(f".{file.name}.{uuid.uuid4().hex}.part"), text)
    with suppress(FileExistsError):  # another process was faster
        os.link(draft, file)
    draft.unlink()
    to_disk(file.parent)
