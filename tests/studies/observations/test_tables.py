"""Tables as people have them: the shapes of one table of shots, and what is no plain number."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from studies.observations import Observation, read_observations
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Plain
from studies.quantities.texts import decoded, strictly_decoded
from studies.sweeps.document import read_sweep_file, with_files
from studies.sweeps.reading import vocabulary
from studies.sweeps.sweep import Sweep
from tests.claims.marked import Compared
from tests.claims.rows import equal

HOLES = vocabulary("thin_plate", {}, {})
HEADINGS = ["speed [km/s]", "plate_thickness [mm]", "hole_diameter [mm]", "hole_diameter_uncertainty [mm]", "source"]
ROWS = [["5.1", "2", "18.3", "0.4", "shot 17, März"], ["6.0", "4", "25.9", "0.5", "shot 18"]]
SIZES = [
    ({"speed": 5100.0, "plate_thickness": 0.002}, 0.0183, 0.0004, "shot 17, März"),
    ({"speed": 6000.0, "plate_thickness": 0.004}, 0.0259, 0.0005, "shot 18"),
]
Cells = Sequence[Sequence[str]]


def table(
    separator: str = ",",
    comma: bool = False,
    quoting: Any = csv.QUOTE_MINIMAL,
    encoding: str = "utf-8",
    end: str = "\r\n",
    headings: Sequence[str] = HEADINGS,
    rows: Cells = ROWS,
) -> bytes:
    """The table as a program writes it."""
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, quoting=quoting, lineterminator=end)
    writer.writerow(headings)
    writer.writerows([[*(cell.replace(".", ",") if comma else cell for cell in row[:-1]), row[-1]] for row in rows])
    return text.getvalue().encode(encoding)


def column(number: int, *cells: str) -> list[list[str]]:
    """The rows with other cells in a column."""
    return [[*row[:number], cell, *row[number + 1 :]] for row, cell in zip(ROWS, cells, strict=True)]


def without_uncertainty(*cells: str, heading: str = "hole_diameter [mm]") -> bytes:
    rows = [[*row[:2], cell, row[4]] for row, cell in zip(ROWS, cells, strict=True)]
    return table(headings=[*HEADINGS[:2], heading, "source"], rows=rows)


# The same shots, as spreadsheets and editors of several countries write them.
SHAPES: dict[str, bytes] = {
    "comma": table(),
    "byte order mark": table(encoding="utf-8-sig"),
    "semicolons": table(";"),
    "semicolons, decimal commas": table(";", comma=True),
    "semicolons, decimal commas, Windows-1252": table(";", comma=True, encoding="cp1252"),
    "semicolons, Latin-1": table(";", encoding="latin-1"),
    "tabs": table("\t"),
    "tabs, decimal commas": table("\t", comma=True),
    "tabs, UTF-16": table("\t", encoding="utf-16"),
    "tabs, decimal commas, UTF-16": table("\t", comma=True, encoding="utf-16"),
    "UTF-16, big end first": b"\xfe\xff" + table(encoding="utf-16-be"),
    "UTF-16 without a mark": table(encoding="utf-16-le"),
    "UTF-32": table(encoding="utf-32"),
    "every cell quoted": table(quoting=csv.QUOTE_ALL),
    "every cell quoted, semicolons, decimal commas": table(";", comma=True, quoting=csv.QUOTE_ALL),
    "decimal commas in quotes": table(comma=True),
    "words quoted": table(quoting=csv.QUOTE_NONNUMERIC),
    "lines that end with a return": table(end="\r"),
    "lines that end with a new line": table(end="\n"),
    "no end of the last line": table().rstrip(),
    "empty columns at the end": table(headings=[*HEADINGS, "", ""], rows=[[*row, "", ""] for row in ROWS]),
    "a column without cells": table(headings=[*HEADINGS[:4], "", "source"], rows=[[*r[:4], "", r[4]] for r in ROWS]),
    "the separator named": b"sep=;\r\n" + table(";"),
    "remarks": b"# gun, spring;;;;\r\n;;;;\r\n" + table(";"),
    "units in parentheses": table(headings=[each.replace("[", "(").replace("]", ")") for each in HEADINGS]),
    "units behind a stroke": table(headings=[each.replace("[", "/ ").replace("]", "") for each in HEADINGS]),
    "headings in capitals": table(
        headings=[each.replace("speed", "Speed").replace("hole_", "Hole ") for each in HEADINGS]
    ),
    "units in the cells": table(
        headings=[each.partition(" ")[0] for each in HEADINGS],
        rows=[[f"{a} km/s", f"{b} mm", f"{c} mm", f"{d} mm", e] for a, b, c, d, e in ROWS],
    ),
    "units in the cells, no blank": table(rows=[[f"{a}km/s", f"{b}mm", f"{c}mm", d, e] for a, b, c, d, e in ROWS]),
    "inches": table(rows=column(1, '0.0787401574803"', "0.15748031496063 in")),
    "plus or minus": without_uncertainty("18.3±0.4", "25.9 ± 0.5"),
    "plus or minus with units": without_uncertainty("18.3 mm ± 0.4", "(25.9 ± 0.5) mm", heading="hole_diameter"),
    "plus or minus in letters": without_uncertainty("18.3 +/- 0.4", "25.9+-0.5"),
    "plus or minus, decimal commas": without_uncertainty("18,3±0,4", "25,9±0,5")
    .replace(b"5.1", b'"5,1"')
    .replace(b"6.0", b'"6,0"'),
    "plus or minus, Latin-1": without_uncertainty("18.3±0.4", "25.9±0.5").decode().encode("latin-1"),
    "blanks around cells": table(rows=[[f" {cell} " for cell in row] for row in ROWS]),
    "blanks that do not break": table(rows=[[f"{cell}\u00a0" for cell in row] for row in ROWS]),
    "signs and exponents": table(rows=column(0, "+5.1", "0.6e1")),
    "N/A in a column": table(headings=[*HEADINGS, "note"], rows=[[*ROWS[0], "N/A"], [*ROWS[1], "-"]]),
    "a name of a column that is empty": table(
        headings=[*HEADINGS, "projectile"], rows=[[*row, "n.a."] for row in ROWS]
    ),
}

REFUSED: dict[str, tuple[bytes, tuple[str, ...]]] = {
    "points and commas": (
        table(";", rows=column(2, "18,3", "25.9")),
        ("line 2: hole_diameter", "decimal points", "line 2: speed"),
    ),
    "a thousand or not": (table(";", rows=[["6,123", "2", "18", "1", "x"]] * 2), ("speed", "6,123", "thousand")),
    "a thousand with points": (table(rows=column(0, "1,234", "6.0")), ("speed", "1,234", "decimal points")),
    "thousands": (table(rows=column(0, "1,234.5", "6.0")), ("speed", "separator of thousands")),
    "commas not in quotes": (table(";", comma=True).replace(b";", b","), ("9 cells", "decimal comma")),
    "two separators": (table().replace(b",", b";", 2), ("comma and semicolon", "one separator")),
    "no separator": (table().replace(b", ", b"").replace(b",", b"|"), ("comma, a semicolon or a tab", "line 1")),
    "a column twice": (
        table(headings=[*HEADINGS[:3], HEADINGS[2], "source"]),
        ("hole_diameter [mm]", "each column once"),
    ),
    "an approximate range of speed": (
        table(rows=column(0, "5.0-5.2", "6.0")),
        ("line 2: speed", "5.0-5.2", "one value"),
    ),
    "a size of 0": (table(rows=column(2, "0", "25.9")), ("line 2: hole_diameter", "above 0", "held")),
    "a range that falls": (table(rows=column(2, "18.7-17.9", "25.9")), ("hole_diameter", "two bounds that ascend")),
    "two uncertainties": (table(rows=column(2, "18.3±0.3", "25.9")), ("hole_diameter", "one uncertainty")),
    "a byte of no encoding": (table().replace("ä".encode(), b"\x81"), ("0x81", "line 2", "Windows-1252")),
    "NUL": (table() + b"\0", ("0x00", "no NUL")),
    "half of UTF-16": (table(encoding="utf-16")[:-1], ("UTF-16",)),
    "no cell for a heading": (table(headings=[*HEADINGS[:3], "", "source"]), ("a heading above each cell",)),
}


def read(content: bytes) -> list[tuple[Any, ...]]:
    shots = read_observations(decoded(content, "observations"), HOLES)
    return [(shot.parameters, shot.value, shot.uncertainty, shot.source) for shot in shots]


@pytest.mark.claim("mend", "tables")
def test_tables__in_every_shape_give_the_same_shots(compared: Compared) -> None:
    """Forty shapes of one table of shots, as programs and people write it, are read as the same shots."""
    assert len(SHAPES) >= 40
    for name, content in SHAPES.items():
        try:
            got: object = read(content)
        except InvalidInput as error:
            got = str(error)
        compared(equal(name, expected=SIZES, got=got))


@pytest.mark.claim("mend", "tables-refused")
def test_tables__that_are_not_plain_are_refused_by_name(compared: Compared) -> None:
    """A table whose meaning is not plain is refused in one error, with its separator, encoding or column."""
    for name, (content, words) in REFUSED.items():
        with pytest.raises(InvalidInput) as caught:
            read(content)
        missing = [word for word in words if word not in str(caught.value)]
        compared(
            equal(
                f"{name}: errors, words that are missing", expected=(1, []), got=(len(caught.value.findings), missing)
            )
        )


def one(cell: str, **columns: str) -> Observation:
    given = {"speed": "6 km/s", "hole_diameter [mm]": cell, "source": "x", **columns}
    [shot] = read_observations([given], HOLES)
    return shot


@pytest.mark.parametrize(
    ("cell", "bounds"),
    [
        ("17.9-18.7", (0.0179, 0.0187)),
        ("17.9 – 18.7 mm", (0.0179, 0.0187)),
        ("17.9 to 18.7", (0.0179, 0.0187)),
        ("1.79 cm - 18.7 mm", (0.0179, 0.0187)),
        (">18.3", (0.0183, None)),
        ("≤ 18.3 mm", (None, 0.0183)),
    ],
)
def test_range__has_bounds_and_no_value_and_is_read_as_it_is_written(cell: str, bounds: object) -> None:
    shot = one(cell)
    assert (shot.value, shot.bounds) == (None, bounds)
    assert read_observations([shot.document(HOLES)], HOLES) == (shot,)


@pytest.mark.parametrize("cell", [float("inf"), 10**400, "1e999"])
def test_number_without_bounds__is_refused(cell: Any) -> None:
    with pytest.raises(InvalidInput, match="hole_diameter"):
        one(cell)


def test_approximate_size__has_no_uncertainty_and_says_so() -> None:
    """What is only about a size tests nothing: it has no uncertainty, but the one that is stated beside it."""
    shot = one("~6.7")
    assert (shot.value, shot.uncertainty, shot.note) == (0.0067, None, "hole_diameter ~6.7")
    assert one("ca. 6,7", **{"hole_diameter_uncertainty [mm]": "0,2"}).uncertainty == 0.0002


def test_parameter_with_an_uncertainty__is_its_value_and_stands_in_the_note() -> None:
    shot = one("18.3", speed="6.2 ± 0.1 km/s", note="day 2")
    assert (shot.parameters["speed"], shot.note) == (6200.0, "day 2; speed 6.2 ± 0.1 km/s")


@pytest.mark.parametrize("nothing", ["", "-", "–", "N/A", "n.a.", "NaN", " - ", float("nan"), None])
def test_cell_that_states_nothing__is_missing(nothing: Any) -> None:
    assert one("18.3", plate_thickness=nothing).parameters == {"speed": 6000.0}


def test_minus_and_hyphens_in_units__are_no_ranges() -> None:
    assert one("18.3", speed="6000 m s-1").parameters == {"speed": 6000.0}
    assert one("1.83e+1").value == 0.0183


def test_refusals__are_one_for_each_column_with_its_first_rows() -> None:
    rows = [["5.1", "thick", "big", "0.4", f"shot {number}"] for number in range(500)]
    with pytest.raises(InvalidInput) as caught:
        read(table(rows=rows))
    fields = [finding.field for finding in caught.value.findings]
    assert fields == [
        "observations, lines 2, 3, 4 and 97 more: plate_thickness",
        "observations, lines 2, 3, 4 and 97 more: hole_diameter",
    ]
    with pytest.raises(InvalidInput) as caught:
        read_observations([{"speed": "fast", "hole_diameter": "1 mm", "source": "x"}] * 2, HOLES)
    assert [finding.field for finding in caught.value.findings] == ["observations[0] (and [1]): speed"]


# ---- doors ---------------------------------------------------------------------------------------

HOSTILE = SHAPES["tabs, decimal commas, UTF-16"]
SWEEP: Mapping[str, Plain] = {
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "al-2017-t4",
        "target": "al-6061-t6",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
    },
    "axes": {"speed": ["5 km/s", "6 km/s"]},
    "resolution": 4,
}


@pytest.mark.parametrize("kind", [str, Path])
def test_dictionary__names_a_table_as_a_file_does(kind: type, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The path of a table of shots is read in a dictionary as in a file, from where the program runs."""
    (tmp_path / "shots.csv").write_bytes(HOSTILE)
    (tmp_path / "sweep.yaml").write_bytes(str({**SWEEP, "observations": "shots.csv"}).encode("utf-16"))
    of_file = Sweep.parse(read_sweep_file(tmp_path / "sweep.yaml"))
    monkeypatch.chdir(tmp_path)
    of_dictionary = Sweep.parse(with_files({**SWEEP, "observations": kind("shots.csv")}, Path()))
    assert [shot.value for shot in of_dictionary.observations] == [0.0183, 0.0259]
    assert of_dictionary.observations == of_file.observations


def test_document__names_no_file_of_the_machine_that_reads_it(tmp_path: Path) -> None:
    """What a service is sent is a document alone: a path in it is refused, and the file is not read."""
    file = tmp_path / "shots.csv"
    file.write_bytes(table())
    for name in (str(file), file, f"file://{file}"):
        with pytest.raises(InvalidInput) as caught:
            Sweep.parse({**SWEEP, "observations": name})
        assert caught.value.findings[0].field == "observations"


def test_missing_table__is_no_such_file_and_a_name_is_none_that_ships(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no such file"):
        with_files({**SWEEP, "observations": "shots.csv"}, tmp_path)
    with pytest.raises(InvalidInput, match="did you mean 'holes'"):
        Sweep.parse(with_files({**SWEEP, "observations": "hole"}, tmp_path))


def test_body__in_another_encoding_is_refused_by_its_name() -> None:
    for content, words in (("ä".encode("latin-1"), "Latin-1"), ("ä".encode("utf-16"), "UTF-16")):
        with pytest.raises(InvalidInput, match=words):
            strictly_decoded(content, "document")
