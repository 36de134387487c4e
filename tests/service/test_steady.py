"""Dask and tornado hear nothing of a clock that is set; in a process of its own, for nothing is put back there."""

import subprocess
import sys
import textwrap

HEAD = '''
    import asyncio, sys, time

    right, shift = time.time, 0
    time.time = lambda: right() + shift
    import distributed
    from distributed.batched import BatchedSend
    from tornado.ioloop import PeriodicCallback
    from service import steady
    steady.keep_time()
    DAY = 86_400

    async def until(condition):
        """For half a minute at most."""
        for _ in range(3000):
            if condition():
                return
            await asyncio.sleep(0.01)
'''


def test_clock_set_back_between_two_batches__sends_the_second_all_the_same() -> None:
    said = _run(
        """
        written = []

        class Comm:
            def closed(self):
                return False

            async def write(self, messages, **_):
                global shift
                written.extend(messages)
                shift = -DAY  # the next batch is to wait for the time that was
                return 1

        async def main():
            stream = BatchedSend("10 ms")
            stream.start(Comm())
            for message in ("before", "after"):
                stream.send(message)
                await until(lambda: message in written)

        asyncio.run(main())
        print(*written)
        """
    )
    assert said == "before after"


def test_clock_set_back__does_not_pause_what_is_done_every_so_often() -> None:
    said = _run(
        """
        beats = []

        async def main():
            global shift
            PeriodicCallback(lambda: beats.append(shift), 20).start()
            await until(lambda: 0 in beats)
            shift = -DAY
            await until(lambda: beats.count(-DAY) > 2)

        asyncio.run(main())
        print(beats.count(-DAY) > 2)
        """
    )
    assert said == "True"


def test_every_part_of_dask__looks_at_the_steady_clock() -> None:
    said = _run(
        """
        shift = DAY
        parts = [one for name, one in sys.modules.items() if name.startswith("distributed.")]
        clocks = [one.time for one in parts if callable(getattr(one, "time", None))]
        print(len(clocks) > 5, all(abs(clock() - right()) < 60 for clock in clocks))
        """
    )
    assert said == "True True"


def _run(body: str) -> str:
    program = textwrap.dedent(HEAD) + textwrap.dedent(body)
    ended = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=180
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.strip()
