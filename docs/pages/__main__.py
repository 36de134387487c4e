"""``python -m docs.pages`` writes the made pages, ``... compute NAME`` computes the results behind one first."""

import sys
from pathlib import Path

from docs.pages import DOCS, accuracy, laws, measurements, shots, validation

PAGES = {
    "accuracy": accuracy,
    "laws": laws,
    "measurements": measurements,
    "shots": shots,
    "validation": validation,
}
COMPUTED = {"accuracy": accuracy, "shots": shots, "validation": validation}


def main(arguments: list[str]) -> None:
    """Compute results where asked to (``compute NAME [DIRECTORY [CASE ...]]``), then write every page and drawing."""
    if arguments:
        _, name, *directory = arguments
        COMPUTED[name].compute(*(Path(each) for each in directory))
    for name, module in PAGES.items():
        (DOCS / f"{name}.md").write_text(module.page(), encoding="utf-8")
        for file, text in module.drawings().items():
            (DOCS / "drawings" / file).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
