"""A hook of mkdocs: README and its neighbours become pages, and what modules of this folder make; links lead to pages,
equations become MathML.

It writes the index of the search as a script too, so that the search works from disk.
"""

import json
import posixpath
import re
from pathlib import Path
from typing import Any

from docs.pages import made

ROOT = Path(__file__).parents[2]
PAGES = {"README.md": "start.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
TABLES = ("verification/", "validation/")
SITE = "build/site/"  # how files of the project link a page that is made

# Code, which is left alone, or an equation between dollar signs as GitHub has them.
PARTS = re.compile(
    r"(?P<code>^```.*?^```|`[^`]*`)|\$\$(?P<block>.+?)\$\$|\$(?P<inline>\S(?:[^$\n]*?\S)?)\$", re.MULTILINE | re.DOTALL
)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that stand outside of docs/, and those that are made with their drawings."""
    from mkdocs.structure.files import File

    for name, page in PAGES.items():
        text = (ROOT / name).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=relinked(text, "")))
    for name, text in made().items():
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Links and equations of a page."""
    return with_equations(relinked(markdown, posixpath.join("docs", posixpath.dirname(page.file.src_uri))))


def on_post_build(config: Any) -> None:
    """The index of the search as a script, which a page from disk may load: sections, without the tables of cases."""
    folder = Path(config["site_dir"]) / "search"
    index = json.loads((folder / "search_index.json").read_text(encoding="utf-8"))
    index["docs"] = [
        each for each in index["docs"] if "#" in each["location"] and not each["location"].startswith(TABLES)
    ]
    (folder / "search_index.js").write_text(f"const search_index = {json.dumps(index)};\n", encoding="utf-8")


def relinked(markdown: str, folder: str) -> str:
    """Links of a file in a folder of the project as links between pages; a file that is no page is left as its text.

    A page that is made is linked where ``make docs`` builds it.
    """
    within = posixpath.relpath(folder or "docs", "docs")  # README becomes a page of docs/

    def link(match: re.Match[str]) -> str:
        image, text, target = match.groups()
        file, mark, anchor = target.partition("#")
        if not file or "://" in target:
            return match[0]
        path = posixpath.normpath(posixpath.join(folder, file))
        page = path.removeprefix("docs/") if path.startswith("docs/") else PAGES.get(path)
        if path.startswith(SITE):
            page = path.removeprefix(SITE).replace(".html", ".md")
        return f"{image}[{text}]({posixpath.relpath(page, within)}{mark}{anchor})" if page else text

    return LINK.sub(link, markdown)


def with_equations(markdown: str) -> str:
    """Equations between dollar signs as MathML."""
    from latex2mathml.converter import convert

    def part(match: re.Match[str]) -> str:
        if match["code"]:
            return match[0]
        if match["block"]:
            return f"<div>{convert(match['block'].strip(), display='block')}</div>"
        # Markdown takes <math> at the begin of a line for a block.
        return f"<span>{convert(match['inline'])}</span>"

    return PARTS.sub(part, markdown)
