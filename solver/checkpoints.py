"""Checkpoints: what a simulation carries from step to step <-> a file, bit for bit.

A file is one line of JSON (fingerprint, numbers, layout of the arrays), the bytes of the arrays behind one another, and
the SHA-256 of all that. It is read only where the run that goes on computes the same bits as the one that wrote it:
same processor, compiler, solver and problem. Anything else, damage included, means "from the start", with a reason.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from solver import PHYSICS_VERSION
from solver.jit import compiler
from solver.problem import Problem

MINUTE = 60.0  # s
MEBIBYTE = 1 << 20
DIGEST_SIZE = hashlib.sha256().digest_size

Fingerprint = Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Checkpointing:
    """The place and the interval of the checkpoint of a run, and the functions of the caller.

    The file is the caller's: it outlives the run, so that a result which could not be kept is soon there again.
    """

    path: Path
    seconds_between: float = MINUTE  # of wall clock
    caller: str = ""  # version of the observer state, which must be the same
    observer_state: Callable[[], str] = str  # stored in the checkpoint
    restore_observer: Callable[[str], object] = lambda _: None  # called before the run continues
    must_stop: Callable[[], bool] = lambda: False  # after each step; true: write, and raise Interrupted
    on_checkpoint: Callable[[int], object] = lambda _: None  # step of a checkpoint, written or restored
    log: Callable[[str], object] = lambda _: None  # where a run continues, or why it starts anew

    def read(self, mark: Fingerprint) -> "Carried | None":
        """The content of the file if it is there and has this fingerprint, or None with the reason in the log."""
        try:
            return read_checkpoint(self.path, mark)
        except FileNotFoundError:
            return None
        except (CheckpointRefused, OSError) as error:
            self.log(f"from the start, without the checkpoint: {error}")
            return None

    def write(self, mark: Fingerprint, carried: "Carried", step: int) -> None:
        """Write the file; a run whose file cannot be written goes on, with the reason in the log."""
        try:
            write_checkpoint(self.path, mark, carried)
        except OSError as error:
            self.log(f"a checkpoint could not be written: {error}")
        else:
            self.on_checkpoint(step)


@dataclass(frozen=True)
class Carried:
    """The state that a simulation carries from one step to the next."""

    numbers: Mapping[str, Any]  # plain objects
    arrays: Mapping[str, np.ndarray]


class CheckpointRefused(Exception):
    """A checkpoint that cannot be used, with the reason."""


def fingerprint(problem: Problem, **others: str) -> Fingerprint:
    """Everything that decides the bits of a run: it continues only where all of it is the same."""
    return {
        **compiler(),
        "numpy": np.__version__,
        "physics": str(PHYSICS_VERSION),
        "problem": content_hash(problem),
        **others,
    }


def content_hash(record: Problem) -> str:
    """SHA-256 of a tree of records, tuples, numbers, words and arrays; TypeError for anything else."""
    digest = hashlib.sha256()
    for piece in _pieces(record):
        digest.update(len(piece).to_bytes(8))
        digest.update(piece)
    return digest.hexdigest()


def write_checkpoint(path: Path, mark: Fingerprint, carried: Carried) -> None:
    """Write a checkpoint: whole, or not at all; raises OSError."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            digest = hashlib.sha256()
            for piece in _content(mark, carried):
                digest.update(piece)
                file.write(piece)
            file.write(digest.digest())
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def read_checkpoint(path: Path, mark: Fingerprint) -> Carried:
    """The content of a checkpoint with this fingerprint. Raises CheckpointRefused and, without a file, OSError."""
    with path.open("rb") as file:
        if not _is_whole(file):
            raise CheckpointRefused("the file is damaged")
        file.seek(0)
        header = json.loads(file.readline())
        found = header["fingerprint"]
        changed = [name for name in sorted({*mark, *found}) if mark.get(name) != found.get(name)]
        if changed:
            raise CheckpointRefused("of another run or machine: different " + ", ".join(changed))
        arrays = {}
        for name, kind, shape in header["arrays"]:
            arrays[name] = np.empty(shape, kind)
            file.readinto(_bytes(arrays[name]))
    return Carried(header["numbers"], arrays)


def _is_whole(file: BinaryIO) -> bool:
    """Whether a file ends with the digest of the bytes before it."""
    left = os.fstat(file.fileno()).st_size - DIGEST_SIZE
    digest = hashlib.sha256()
    while left > 0:
        piece = file.read(min(left, MEBIBYTE))
        digest.update(piece)
        left -= len(piece)
    return digest.digest() == file.read()


def _content(mark: Fingerprint, carried: Carried) -> Iterator[bytes | memoryview]:
    layout = [(name, array.dtype.str, array.shape) for name, array in carried.arrays.items()]
    header = {"fingerprint": dict(mark), "numbers": carried.numbers, "arrays": layout}
    yield json.dumps(header).encode() + b"\n"  # repr of a float gives the same bits back
    for array in carried.arrays.values():
        yield _bytes(array)


def _bytes(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data


def _pieces(value: Any) -> Iterator[bytes | memoryview]:
    """Bytes that differ for any two different values."""
    yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str} {value.shape}".encode()
        yield _bytes(value)
    elif is_dataclass(value):
        for one in fields(value):
            yield from _pieces(getattr(value, one.name))
    elif isinstance(value, tuple):
        yield str(len(value)).encode()
        for item in value:
            yield from _pieces(item)
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        yield repr(value).encode()
    else:
        raise TypeError(f"a problem holds a {type(value)}, which has no content hash")
