"""The fenced blocks of a page, run in their order in a clone, as they stand."""

import os
import re
import signal
import socket
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import yaml

from tests.claims.rows import Row
from tests.service.support.fakes import is_gone, wait_until
from tests.service.support.processes import ROOT, free_port

FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"[\w-]+\.(?:nc|html|json)\b")
PORT = 8000  # of the text
LAST = 600  # characters of a block's output, for whoever reads why it failed
LEAVE_SECONDS = 60.0  # that programs have after Ctrl-C, and again after SIGTERM

# Commands that take up to hours, with what they print once they compute (a regular expression); then they are ended.
LONG = {
    "make demo-full": r"\d+/\d+ runs",
    "make test": "  passed  ",
    "make pythons": "  passed  ",
    # Whether claims hold is theirs to say: some are about speed, and none holds on a machine that does much else.
    "make claims": r"(?m)^\d+ tests$",
    "make claims house": r"\| (PASS|FAIL|REPORT)",
    "make claims speed": r"\| (PASS|FAIL|REPORT)",
    "make soak": r"\| PASS",
    "make bench": r"(?m)^    \w+ +\d",
    "tests.benchmarks steps memory": r"(?m)^    \w+ +\d",
}
# What machines lack: a text of blocks or commands, and a command that ends well with all that they need.
NEEDED = {
    "docker compose": "docker compose version && docker info",
    "SLURMCluster": "sbatch --version",
    "make pythons": "python3.11 --version && python3.12 --version && python3.13 --version",
}

# A sweep whose lines the yaml blocks of a page replace, where the page has none of its own.
SMALL = {
    "name": "small",
    "scenario": "thin_plate",
    "fixed": {**dict.fromkeys(("projectile", "target"), "copper-ofhc"), "projectile_diameter": "8 mm"},
    "axes": {"speed": ["4 km/s"], "plate_thickness": ["2 mm"]},
    "resolution": 16,
}

# The Python blocks of a page are one session: each is a file that is named on a line, run, and answered beside it.
SESSION = """
import sys, traceback
namespace = {"__name__": "__main__"}
for line in sys.stdin:
    file = line.strip()
    status = 0
    try:
        exec(compile(open(file).read(), file, "exec"), namespace)
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    open(file + ".part", "w").write(str(status))
    __import__("os").replace(file + ".part", file + ".status")
"""


@dataclass(frozen=True)
class Block:
    """A fenced block of a text."""

    language: str
    text: str
    line: int

    @property
    def commands(self) -> list[str]:
        """The lines of a shell, without comments."""
        lines = self.text.replace("\\\n", " ").splitlines()
        return [line for line in (re.sub(r"(^|\s+)#.*$", "", line) for line in lines) if line]


@dataclass
class Reader:
    """Somebody who follows a text in a clone, with one shell and one Python session."""

    clone: Path
    environment: Mapping[str, str]
    seconds: float  # that a block may take
    page: str = "README"  # of the files beside the clone
    programs: "list[subprocess.Popen[str]]" = field(default_factory=list)  # each with a session of its own
    python: "subprocess.Popen[str] | None" = None

    def row_of(self, block: Block) -> Row:
        """What a block does, as its language has it; REPORT and the reason where the machine lacks what it needs."""
        if reason := lacking(block.text):
            return Row(f"line {block.line}, not run", "", reason, None)
        does = {"sh": self._shell, "python": self._python, "csv": self._table, "yaml": self._lines}
        return does.get(block.language, self._listing)(block)

    def run(self, block: Block, *command: str | Path) -> Row:
        """A program, which must end well; what it leaves in the background is not waited for."""
        log = self._beside(block, "log")
        process = self._start(log, command, subprocess.DEVNULL)
        return _ended(f"line {block.line}", process.wait(self.seconds), log)

    def command(self, command: str) -> Row:
        """A line of a shell, which must end well; one of ``LONG``, as soon as it computes."""
        if reason := lacking(command):
            return Row(f"{command}, not run", "", reason, None)
        log, begun = self.clone.with_name("command.log"), begun_by(command)
        process = self._start(log, ["sh", "-c", command], subprocess.DEVNULL)
        if begun is None:
            return _ended(command, process.wait(self.seconds), log)

        def is_begun() -> bool:
            return re.search(begun, log.read_text(errors="replace")) is not None

        try:
            wait_until(lambda: process.poll() is not None or is_begun(), seconds=self.seconds, pause=0.5)
        finally:
            interrupt(process)
        output = "" if is_begun() else f": {log.read_text(errors='replace')[-LAST:]}"
        return Row(f"{command}, prints what it computes", True, f"{is_begun()}{output}", is_begun())

    def end(self) -> None:
        """Tell every program that the blocks started to leave, also in the background, and wait until it has."""
        if self.python is not None and self.python.stdin is not None:
            self.python.stdin.close()
        for pid in self._running():
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
        wait_until(lambda: not self._running())

    def _running(self) -> list[int]:
        """The processes of the sessions of all programs."""
        sessions, running = {program.pid for program in self.programs}, []
        for pid in psutil.pids():
            with suppress(ProcessLookupError):
                if os.getsid(pid) in sessions and not is_gone(pid):
                    running.append(pid)
        return running

    def _start(self, log: Path, command: Sequence[str | Path], stdin: int) -> subprocess.Popen[str]:
        """A program in the clone, in a session of its own, with its output in a file."""
        with log.open("wb") as file:
            process = subprocess.Popen(
                command,
                cwd=self.clone,
                env=self.environment,
                stdin=stdin,
                stdout=file,
                stderr=file,
                text=True,
                start_new_session=True,
            )
        self.programs.append(process)
        return process

    def _beside(self, block: Block, ending: str) -> Path:
        return self.clone.with_name(f"{self.page}-line-{block.line}.{ending}")

    def _shell(self, block: Block) -> Row:
        """A block of a shell, with the variables of the blocks before it."""
        kept = self.clone.with_name(f"{self.page}.variables")
        restored = f"set -a\n[ ! -f {kept} ] || . {kept}\n"
        saved = f"\nexport -p > {kept}\n"
        return self.run(block, "sh", "-e", "-c", restored + block.text + saved)

    def _python(self, block: Block) -> Row:
        """A block of Python, after those before it."""
        code, log = self._beside(block, "py"), self.clone.with_name(f"{self.page}-python.log")
        code.write_text(block.text)
        if self.python is None:
            kept = self.clone.with_name(f"{self.page}.variables")
            program = f"[ ! -f {kept} ] || . {kept}; exec .venv/bin/python -c '{SESSION}'"
            self.python = self._start(log, ["sh", "-c", program], subprocess.PIPE)
        assert self.python.stdin is not None
        self.python.stdin.write(f"{code}\n")
        self.python.stdin.flush()
        answer = code.with_name(f"{code.name}.status")
        wait_until(answer.exists, seconds=self.seconds)
        return _ended(f"line {block.line}", int(answer.read_text()), log)

    def _table(self, block: Block) -> Row:
        (self.clone / "shots.csv").write_text(block.text)
        return Row(f"line {block.line}, a table to be named", "", "shots.csv", None)

    def _lines(self, block: Block) -> Row:
        """Lines of a sweep document, in place of those that the page's own sweep has."""
        file = self.clone / f"{self.page}-line-{block.line}.yaml"
        own = [self.clone / "holes.yaml", self.clone / "first.yaml"]
        texts = [yaml.safe_load(each.read_text()) for each in own if each.exists()]
        lines, document = yaml.safe_load(block.text), dict((texts or [SMALL])[0])
        if "accuracy" in lines:  # an accuracy takes the place of a resolution
            document.pop("resolution")
        file.write_text(yaml.safe_dump({**document, **lines}))
        return self.run(block, ".venv/bin/whipple", "estimate", file)

    def _listing(self, block: Block) -> Row:
        """Folders at the begin of each line, and the files that it names in them."""
        missing = []
        for line in block.text.splitlines():
            folder = self.clone / line.split()[0]
            names = [folder, *(folder / name for name in FILE.findall(line))]
            missing += [str(name.relative_to(self.clone)) for name in names if not name.exists()]
        return Row(f"line {block.line}, listed and missing", [], missing, not missing)


def _ended(name: str, status: int, log: Path) -> Row:
    output = "" if status == 0 else f": {log.read_text(errors='replace')[-LAST:]}"
    return Row(f"{name}, exit status", 0, f"{status}{output}", status == 0)


def interrupt(process: "subprocess.Popen[str]") -> None:
    """End a program and all that it started: Ctrl-C for its process group, then SIGTERM and SIGKILL for those left."""
    if process.poll() is not None:
        return
    family = [process, *psutil.Process(process.pid).children(recursive=True)]
    os.killpg(process.pid, signal.SIGINT)
    for number in (signal.SIGTERM, signal.SIGKILL):
        with suppress(AssertionError):
            wait_until(
                lambda: process.poll() is not None and all(is_gone(each.pid) for each in family), seconds=LEAVE_SECONDS
            )
        for each in family:
            if not is_gone(each.pid):
                with suppress(psutil.NoSuchProcess):
                    each.send_signal(number)
    process.wait(LEAVE_SECONDS)


def begun_by(command: str) -> str | None:
    """What a command of ``LONG`` prints once it computes; None for any other."""
    options = r"( [A-Z]+=\S+)*( \S+\.json)?$"
    return next((said for text, said in LONG.items() if re.search(re.escape(text) + options, command)), None)


def is_long(block: Block) -> bool:
    """Whether one of the lines of a block takes up to hours."""
    return block.language == "sh" and any(begun_by(each) for each in block.commands)


def lacking(text: str) -> str:
    """The reason why a block or a command cannot be run on this machine; empty where it can."""
    for part, command in NEEDED.items():
        if part in text and subprocess.run(["sh", "-c", command], capture_output=True, check=False).returncode:
            return f"{command!r} fails on this machine"
    return ""


def blocks_of(page: Path) -> list[Block]:
    """Those of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [Block(result[1], result[2], text.count("\n", 0, result.start()) + 1) for result in FENCED.finditer(text)]


def cloned(place: Path) -> Path:
    """A clone of this checkout in a new folder, with what is changed here and not committed yet."""
    clone = place / "whipple"
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    change = ["git", "diff", "--binary", "HEAD"]
    changed = subprocess.run(change, cwd=ROOT, check=True, capture_output=True).stdout
    if changed:
        subprocess.run(["git", "apply"], cwd=clone, input=changed, check=True)
    return clone


def new_environment(clone: Path) -> Path:
    """The environment of a clone with all that its checks use, set up from nothing by its Makefile."""
    subprocess.run(["make", ".venv/claims.stamp"], cwd=clone, env=surroundings(), check=True)
    return clone / ".venv"


def surroundings(port: int | None = None) -> dict[str, str]:
    """The environment without our variables and those of a make; with another port where that of the text is taken."""
    ours = re.compile(r"WHIPPLE_|PYTHON|VIRTUAL_ENV|MAKE|MFLAGS|PYTEST|(NAME|VENV|OUT|SEED|JSON|VERSION|IMAGE)$")
    plain = {name: value for name, value in os.environ.items() if not ours.match(name)}
    with socket.socket() as client:
        if port is None and client.connect_ex(("127.0.0.1", PORT)) == 0:
            port = free_port()
    return plain | ({"WHIPPLE_PORT": str(port), "WHIPPLE_SERVICE": f"http://127.0.0.1:{port}"} if port else {})
