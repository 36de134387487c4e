"""A release: ``make release VERSION=1.2.3``, or ``python -m docs.release 1.2.3 [--without-image]``.

Version, changelog and citation get the number in one commit; wheel, source distribution and image are built from that
commit, and it is tagged once all of them are there. Repeated after a failure, it goes on. Nothing is uploaded.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from datetime import date
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
NUMBER = r"(\d+)\.(\d+)\.(\d+)"
UNRELEASED = "## Unreleased\n"
BUILD = "import sys, setuptools.build_meta as b; out = sys.argv[1]; b.build_wheel(out); b.build_sdist(out)"


def versions(root: Path) -> dict[str, str]:
    """The version that each file states; the changelog, that of its newest release, none before the first."""
    stated = {
        "pyproject.toml": tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"],
        "CITATION.cff": str(yaml.safe_load((root / "CITATION.cff").read_text())["version"]),
    }
    if newest := re.search(rf"^## ({NUMBER})", (root / "CHANGELOG.md").read_text(), re.MULTILINE):
        stated["CHANGELOG.md"] = newest[1]
    return stated


def state_version(root: Path, version: str, today: str) -> None:
    """Write a version into every file that states one; raises ValueError for one that is not newer than the last."""
    stated = versions(root)
    if not re.fullmatch(NUMBER, version):
        raise ValueError(f"{version!r} is no version; write three numbers, for example 1.2.3")
    if "CHANGELOG.md" in stated and _parts(version) <= _parts(stated["CHANGELOG.md"]):
        raise ValueError(f"{version} is not newer than {stated['CHANGELOG.md']}, the last release")
    for name, pattern, replacement in (
        ("pyproject.toml", rf'^version = "{NUMBER}"$', f'version = "{version}"'),
        ("CITATION.cff", rf"^version: {NUMBER}$(\ndate-released:.*)?", f"version: {version}\ndate-released: {today}"),
        ("CHANGELOG.md", f"^{UNRELEASED}", f"{UNRELEASED}\n## {version} ({today})\n"),
    ):
        text = (root / name).read_text(encoding="utf-8")
        changed = re.sub(pattern, replacement, text, count=1, flags=re.MULTILINE)
        (root / name).write_text(changed, encoding="utf-8")


def build(root: Path, version: str, *, with_image: bool) -> list[str]:
    """Build what is published from the last commit, and return what was built."""
    out = root / "dist"
    out.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as source:
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=root, check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", source], input=archive, check=True)
        _run(source, sys.executable, "-c", BUILD, str(out))
        files = [str(out / f"whipple-{version}{ending}") for ending in ("-py3-none-any.whl", ".tar.gz")]
        _run(source, sys.executable, "-m", "twine", "check", "--strict", *files)
        if not with_image:
            return files
        image = f"whipple:{version}"
        label = f"org.opencontainers.image.version={version}"
        engine = shutil.which("docker") or shutil.which("podman")
        if engine is None:
            sys.exit("no docker or podman here; install one, or release with IMAGE=no and build the image elsewhere")
        _run(source, engine, "build", "--tag", image, "--tag", "whipple:latest", "--label", label, ".")
    return [*files, image]


def main() -> int:
    """Release a version; the exit status."""
    parser = argparse.ArgumentParser(prog="make release", description="Release a version; nothing is uploaded.")
    parser.add_argument("version")
    parser.add_argument("--without-image", action="store_true", help="where neither docker nor podman is installed")
    asked = parser.parse_args()
    if subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, check=True, capture_output=True).stdout:
        sys.exit("the checkout has changes; commit them first")
    if set(versions(ROOT).values()) != {asked.version} or len(versions(ROOT)) < 3:  # else: repeated after a failure
        try:
            state_version(ROOT, asked.version, date.today().isoformat())
        except ValueError as error:
            sys.exit(str(error))
        _run(ROOT, "git", "commit", "--quiet", "--all", "--message", f"Release {asked.version}")
    built = build(ROOT, asked.version, with_image=not asked.without_image)
    _run(ROOT, "git", "tag", "--annotate", f"v{asked.version}", "--message", f"whipple {asked.version}")
    print("\n".join(["built, and tagged as v" + asked.version, *built]))
    return 0


def _parts(version: str) -> tuple[int, ...]:
    return tuple(map(int, version.split(".")))


def _run(folder: str | Path, *command: str) -> None:
    """Run a program; what it prints is shown where it fails, which ends the release without a tag."""
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}{done.stderr}{command[0]} failed; correct it, and release the same version again")


if __name__ == "__main__":
    sys.exit(main())
