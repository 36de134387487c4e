"""A wall clock that a test sets for a service alone: a library that is loaded before all others (LD_PRELOAD).

It adds the seconds in a file, if there is one, to what ``clock_gettime(CLOCK_REALTIME)`` says; clocks that nobody can
set stay. The times of files are the kernel's, and stay too.
"""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

FILE = "WHIPPLE_TEST_CLOCK"
SOURCE = f"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

int clock_gettime(clockid_t clock, struct timespec *now) {{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int failed = real(clock, now);
    const char *name = getenv("{FILE}");
    if (failed || clock != CLOCK_REALTIME || !name) return failed;
    FILE *file = fopen(name, "r");
    long long seconds = 0;
    if (file) {{
        if (fscanf(file, "%lld", &seconds) == 1) now->tv_sec += seconds;
        fclose(file);
    }}
    return 0;
}}
"""


@dataclass(frozen=True)
class SetClock:
    """The clock of a service."""

    library: Path
    file: Path

    @property
    def environment(self) -> dict[str, str]:
        """The variables with which the service has this clock."""
        return {"LD_PRELOAD": str(self.library), FILE: str(self.file)}

    def set(self, seconds: float) -> None:
        """Let the clock be so many seconds ahead of the machine's."""
        part = self.file.with_suffix(".part")
        part.write_text(f"{seconds:.0f}")
        os.replace(part, self.file)


def set_clock(folder: Path) -> SetClock:
    """A clock for a service; skips the test where there is no C compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler, which makes the clock")
    source, library = folder / "clock.c", folder / "clock.so"
    source.write_text(SOURCE)
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    return SetClock(library, folder / "clock.txt")
