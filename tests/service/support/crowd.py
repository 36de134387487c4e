"""Clients by the dozen in a process of their own, for a while: each sends what it is told again and again.

A text that is no whole request is sent, and nothing more, until the service ends the connection. What was answered is
counted in the output, by the first line of the answer::

    echo '{"port": 8000, "count": 64, "seconds": 3, "texts": ["GET / ..."]}' | python -m tests.service.support.crowd
"""

import asyncio
import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

PAUSE_SECONDS = 0.05  # between an end and the next connection
PIECE = 1 << 16
WAIT_SECONDS = 30.0  # for the end of the process


async def _send(port: int, text: str, ends: float, answers: Counter[str]) -> None:
    """Send a text, and read until the service ends the connection, or the time is over."""
    try:
        async with asyncio.timeout(max(0.0, ends - time.monotonic())):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            try:
                writer.write(text.encode())
                line = (await reader.readline()).decode().strip()
                while await reader.read(PIECE):
                    pass
                answers[line] += 1
            finally:
                writer.close()
    except TimeoutError:
        answers["no answer"] += 1
    except OSError as error:
        answers[type(error).__name__] += 1


async def _crowd(port: int, count: int, seconds: float, texts: Sequence[str]) -> Counter[str]:
    ends, answers = time.monotonic() + seconds, Counter[str]()

    async def again_and_again(first: int) -> None:
        number = first
        while time.monotonic() < ends:
            await _send(port, texts[number % len(texts)], ends, answers)
            number += 1
            await asyncio.sleep(PAUSE_SECONDS)

    await asyncio.gather(*(again_and_again(number) for number in range(count)))
    return answers


@contextmanager
def crowd(port: int, texts: Sequence[str], *, seconds: float, count: int = 64) -> Iterator["subprocess.Popen[str]"]:
    """The process of such clients, which ends by itself; it is ended with the block at the latest."""
    process = subprocess.Popen(
        [sys.executable, "-m", __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdin is not None
        json.dump({"port": port, "count": count, "seconds": seconds, "texts": list(texts)}, process.stdin)
        process.stdin.close()
        yield process
    finally:
        process.kill()
        process.wait()


def answers_of(process: "subprocess.Popen[str]") -> Counter[str]:
    """What was answered to a crowd, once it has ended."""
    assert process.stdout is not None
    assert process.wait(WAIT_SECONDS) == 0
    return Counter(json.loads(process.stdout.read()))


if __name__ == "__main__":
    print(json.dumps(asyncio.run(_crowd(**json.load(sys.stdin)))))
