"""A store of objects that speaks S3, in a process of its own on the loopback, which stops answering and goes on::

    python -m tests.service.bucket.object_store PORT

Each line of its stdin, ``stop`` or ``start``, is confirmed by a line on stdout; the objects stay until stdin ends.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from unittest.mock import patch

from service.bucket.bucket import ObjectBucket
from tests.service.support.processes import ROOT, free_port

URL = "s3://results/whipple"
CREDENTIALS = {"AWS_ACCESS_KEY_ID": "any", "AWS_SECRET_ACCESS_KEY": "other", "AWS_DEFAULT_REGION": "us-east-1"}


@dataclass(frozen=True)
class ObjectStore:
    """The process, and the bucket for which services have its URL in ``WHIPPLE_ARTIFACTS``."""

    process: "subprocess.Popen[str]"

    def tell(self, word: str) -> None:
        """Let it stop, or start; returns when it has."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(word, file=self.process.stdin, flush=True)
        assert self.process.stdout.readline().strip() == word

    @property
    def bucket(self) -> ObjectBucket:
        return ObjectBucket(URL)

    def flip(self, name: str) -> None:
        path = f"{URL}/{name}"
        content = bytearray(self.bucket.files.cat_file(path))
        content[len(content) // 2] ^= 1
        self.bucket.files.pipe_file(path, bytes(content))


@contextmanager
def object_store() -> Iterator[ObjectStore]:
    """A store with an empty bucket, which this process and those that it starts use, until the end of the block."""
    port = free_port()
    surroundings = {**CREDENTIALS, "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}", "WHIPPLE_ARTIFACTS": URL}
    with (
        patch.dict(os.environ, surroundings),
        subprocess.Popen(
            [sys.executable, "-m", __name__, str(port)],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        ) as process,
    ):
        store = ObjectStore(process)
        store.tell("start")
        store.bucket.files.mkdir("results")
        try:
            yield store
        finally:
            process.kill()


def main(port: int) -> None:
    """Answer as the lines of stdin say."""
    from moto.server import ThreadedMotoServer

    server, out = None, os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        if line.strip() == "start":
            server = ThreadedMotoServer("127.0.0.1", port, verbose=False)
            server.start()
        elif server is not None:
            server.stop()
        print(line.strip(), file=out, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
