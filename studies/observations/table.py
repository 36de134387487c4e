"""Tables as people have them: the rows of a CSV text or of a list of mappings, and what a cell says of a number.

The separator is the one of comma, semicolon and tab that the heading has. A comma inside a number is a decimal comma
where some cell of the table can have no other ("18,3") and none has a decimal point; "1,234" alone could be a thousand,
and is refused, as every separator of thousands is.
"""

import csv
import io
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from typing import TypeGuard

from studies.quantities.findings import Finding, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import Parameter, Plain, Value, parse_value
from studies.quantities.units import is_number

Rows = list[tuple[str, Mapping[str, Plain]]]  # each with its place: "observations, line 3", "observations[2]"

MOST_ROWS = 10_000  # a table of shots; more is another kind of file
MOST_LINES = 10 * MOST_ROWS  # lines of a text, with empty lines and remarks
LONGEST_NUMBER = 80  # characters; as LONGEST_TEXT of a quantity
MOST_REFUSED = 200  # errors of rows, where the reading of a table stops
MOST_PLACES = 3  # rows that the error of a column names
TO = " to "  # between the bounds of a range: "27.5 to 34.5"
ABOVE, BELOW = ">", "<"  # before a bound: ">18.3"
TEXT_COLUMNS = ("source", "confidence", "note")
SEPARATORS: Mapping[str, str] = {",": "comma", ";": "semicolon", "\t": "tab"}
NOTHING = frozenset({"", "-", "--", "–", "—", "na", "n/a", "n.a.", "#n/a", "nan"})  # cells that state nothing
YES_OR_NO: Mapping[str, bool] = {
    **dict.fromkeys(("yes", "y", "true", "p", "perforated", "1"), True),
    **dict.fromkeys(("no", "n", "false", "np", "not perforated", "held", "0"), False),
}

# Each matches a text in one way only, so that a long text that does not match is refused at once.
_HEADING = re.compile(r"([\w.]+(?:[ -][\w.]+)*)\s*(?:\[([^\[\]]*)\]|\((.*)\)|/\s*(\S.*))?")
_NUMBER = r"[+-]?(?:(?:\d{1,4} )?\d{1,4}/\d{1,4}|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"  # a fraction of an inch too
_PART = re.compile(rf"({_NUMBER})(?![\d.])\s*(.*)", re.DOTALL)  # a number and its unit
_SIDES = re.compile(r" to |\s+[-–—]\s+|(?<=[\d.])[-–—](?=[\d.])")
_PLUS_MINUS = re.compile(r"\s*(?:±|\+/-|\+-)\s*")
_ABOUT = re.compile(r"(?:~|≈|ca\.?\s|approx\.?\s|about\s)\s*(?=[\d.<>])")
_BOUND = re.compile(r"([<>≤≥])=?\s*")
_PLAIN = str.maketrans({"\u2212": "-", "\u00a0": " ", "\u202f": " ", "\u2009": " ", "\ufeff": ""})
# A cell that is about numbers, and the numbers in it; digits behind a letter are those of a unit.
_OF_NUMBERS = re.compile(r"[\s~≈<>≤≥=(+\-\u2212]*(?:ca\.?\s*|approx\.?\s*|about\s*)?[+\-\u2212]?[.,]?\d")
_DIGITS = re.compile(r"(?<![\w.,])\d*(?:[.,]\d+)+")


# --- rows ------------------------------------------------------------------------------------------


def rows_of(raw: object, path: str, columns: str = "", texts: Collection[str] = TEXT_COLUMNS) -> Rows:
    """The rows of a CSV text or a list of mappings with decimal points, whose ``texts`` are columns of words.

    Raises InvalidInput, whose cure says which ``columns`` there are.
    """
    if isinstance(raw, str):
        rows = list(islice(_rows_of_text(raw, path), MOST_ROWS + 1))
    elif isinstance(raw, list | tuple):
        for number, row in enumerate(raw):
            if not isinstance(row, Mapping):
                raise refusal(f"{path}[{number}]", row, "a mapping", "write speed: 6 km/s, ...")
        rows = [(f"{path}[{number}]", row) for number, row in enumerate(raw[: MOST_ROWS + 1])]
    else:
        raise refusal(path, raw, "CSV text or a list of shots", columns)
    if len(rows) > MOST_ROWS:
        raise refusal(path, f"more than {MOST_ROWS} rows", f"at most {MOST_ROWS} rows", "split the table")
    return _with_points(rows, texts)


def _rows_of_text(text: str, path: str) -> Iterator[tuple[str, Mapping[str, Plain]]]:
    """The lines of a CSV text without empty lines and remarks, which begin with #."""
    lines = list(islice(io.StringIO(text.removeprefix("\ufeff"), newline=None), MOST_LINES + 1))
    if len(lines) > MOST_LINES:
        limit = f"at most {MOST_LINES} lines"
        raise refusal(path, f"more than {MOST_LINES} lines", limit, "leave empty lines and remarks out")
    separator = _separator(lines, path)
    header: list[str] | None = None
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            where = f"{path}, line {reader.line_num}"
            if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith(("#", "sep=")):
                continue
            if header is None:
                header = _header(cells, where)
                continue
            if any(cell.strip() for cell in cells[len(header) :]) or len(cells) < len(header):
                limit = f"{len(header)} cells parted by a {SEPARATORS[separator]}, as in the heading"
                comma = ", and a number that has a decimal comma" if separator == "," else ""
                cure = f"quote a text that has a {SEPARATORS[separator]}{comma}"
                raise refusal(where, f"{len(cells)} cells", limit, cure)
            row = dict(zip(header, cells, strict=False))
            if row.pop("", "").strip():
                raise refusal(where, cells[header.index("")], "a heading above each cell", "name the column")
            yield where, row
    except csv.Error as error:
        raise refusal(f"{path}, line {reader.line_num}", str(error), "CSV text", "correct this line") from None
    if header is None:
        raise refusal(path, "no header", "a header and a row a shot", "leave observations out")


def _separator(lines: Sequence[str], path: str) -> str:
    """The separator of a table, by its heading; raises InvalidInput where several could be."""
    for number, line in enumerate(lines, 1):
        named = re.fullmatch(r'"?sep=([,;\t])"?\s*', line)  # as spreadsheets write it in the first line
        if named:
            return named[1]
        text = line.strip("\r\n ")
        if not text.strip('",;\t ') or text.lstrip('"').startswith("#"):
            continue
        outside = re.sub(r'"[^"]*"|\[[^\[\]]*\]|\([^()]*\)', "", text)
        found = [mark for mark in SEPARATORS if mark in outside]
        there = [mark for mark in found if mark in outside.strip("\t ")] or found
        if len(there) > 1:
            there = [mark for mark in there if all(_HEADING.fullmatch(part.strip(' "')) for part in text.split(mark))]
        if len(there) == 1:
            return there[0]
        where = f"{path}, line {number}"
        if found:
            names = " and ".join(SEPARATORS[mark] for mark in found)
            raise refusal(where, f"{names} in the heading", "one separator", "part the cells by one of them")
        if _HEADING.fullmatch(text.strip('"')) is None:
            limit = "a heading whose cells are parted by a comma, a semicolon or a tab"
            raise refusal(where, text, limit, "save the table as CSV")
        break
    return ","


def _header(cells: Sequence[str], where: str) -> list[str]:
    """The headings, without empty ones at the end; raises InvalidInput where one occurs twice."""
    header = [cell.strip() for cell in cells]
    while not header[-1]:
        header.pop()
    for number, heading in enumerate(header):
        if heading and heading in header[:number]:
            raise refusal(f"{where}: {heading}", heading, "each column once", "remove one of the two")
    return header


def _with_points(rows: Rows, texts: Collection[str]) -> Rows:
    """The rows with decimal points in the place of commas; raises InvalidInput where a comma may be something else."""
    commas, unclear, points = None, None, None
    cells = [(f"{where}: {heading}", heading, cell) for where, row in rows for heading, cell in row.items()]
    of_numbers = [(place, cell) for place, heading, cell in cells if _is_of_numbers(cell, heading, texts)]
    for place, cell in of_numbers:
        for number in _DIGITS.findall(cell):
            if "," in number and (number.count(",") > 1 or "." in number):
                raise refusal(place, cell, "a number without a separator of thousands", "remove it")
            if "," not in number:
                points = points or (place, cell)
            elif len(number.partition(",")[2]) == 3 and number[0] not in "0," and number.index(",") < 4:
                unclear = unclear or (place, cell)
            else:
                commas = commas or (place, cell)
    if (commas or unclear) and points:
        limit = f"decimal points or decimal commas, and not both: {points[1].strip()!r} is in {points[0]}"
        raise refusal(*(commas or unclear or points), limit, "write decimal points")
    if unclear and not commas:
        raise refusal(*unclear, "a number that is not a thousand as well", "write a decimal point, or no comma")
    if not commas:
        return rows

    def pointed(heading: str, cell: Plain) -> Plain:
        if not _is_of_numbers(cell, heading, texts):
            return cell
        return _DIGITS.sub(lambda number: number[0].replace(",", "."), cell)

    return [(where, {heading: pointed(heading, cell) for heading, cell in row.items()}) for where, row in rows]


def _is_of_numbers(cell: Plain, heading: str, texts: Collection[str]) -> TypeGuard[str]:
    return isinstance(cell, str) and heading not in texts and _OF_NUMBERS.match(cell) is not None


# --- errors ----------------------------------------------------------------------------------------


class FindingsOfRows:
    """The errors of a table: the first of each column, with the rows that have one."""

    def __init__(self, path: str):
        self.path = path
        self.columns: dict[str, tuple[Finding, list[str]]] = {}
        self.count = 0

    @contextmanager
    def of(self, where: str) -> Iterator[None]:
        """Keep the errors of a row, which is left out then. Raises InvalidInput where too many are refused."""
        try:
            yield
        except InvalidInput as error:
            self.extend(where, error.findings)

    def extend(self, where: str, findings: Iterable[Finding]) -> None:
        """Add the errors of a row."""
        for finding in findings:
            column = finding.field.removeprefix(where)
            _, places = self.columns.setdefault(column or finding.value, (finding, []))
            if where not in places[-1:]:
                places.append(where)
            self.count += 1
        if self.count >= MOST_REFUSED:
            self.check()

    def check(self) -> None:
        """Raise InvalidInput with an error for each column, if there are any."""
        if self.columns:
            raise InvalidInput(
                replace(first, field=f"{self._places(places)}{first.field.removeprefix(places[0])}")
                for first, places in self.columns.values()
            )

    def _places(self, places: Sequence[str]) -> str:
        """ "observations, lines 3, 4, 5 and 7 more", or "observations[2] (and [3], [4] and 7 more)"."""
        if len(places) == 1:
            return places[0]
        numbers = [place.removeprefix(self.path).removeprefix(", line ") for place in places[:MOST_PLACES]]
        left = len(places) - len(numbers)
        more = f" and {left} more" if left else ""
        if "[" in numbers[0]:
            return f"{places[0]} (and {', '.join(numbers[1:])}{more})"
        return f"{self.path}, lines {', '.join(numbers)}{more}"


# --- cells -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Stated:
    """What a cell says of a number, as texts with their units."""

    value: Plain = None
    plus_minus: str | None = None
    bounds: tuple[str | None, str | None] | None = None  # of a range, or of one that is open
    about: str = ""  # the cell, where it is no exact number


def heading_of(heading: object, known: Collection[str], where: str) -> tuple[str, str | None]:
    """The name of a column and its unit: of "speed [km/s]", "Speed (km/s)" or "speed / km/s"; raises InvalidInput."""
    match = _HEADING.fullmatch(heading.strip()) if isinstance(heading, str) else None
    units = [unit.strip() for unit in match.groups()[1:] if unit is not None] if match else []
    if match is None or "" in units:
        raise refusal(f"{where}: {shown(heading)}", heading, "name [unit]", "write 'speed [km/s]'")
    name = re.sub("[ -]", "_", match[1])
    if name not in known and name.lower() in known:
        name = name.lower()
    return name, units[0] if units and units[0] not in ("1", "-") else None


def is_nothing(cell: object) -> bool:
    """Whether a cell states nothing: empty, "-", "N/A", or a NaN."""
    if isinstance(cell, str):
        return cell.strip().lower() in NOTHING
    return cell is None or (is_number(cell) and cell != cell)


def stated(cell: Plain, unit: str | None) -> Stated:
    """What a cell says of a number in a column of a unit.

    >>> stated("18.3 ± 0.4", "mm")
    Stated(value='18.3 mm', plus_minus='0.4 mm', bounds=None, about='18.3 ± 0.4')
    >>> stated("17.9-18.7", "mm").bounds, stated(">18.3 mm", None).bounds
    (('17.9 mm', '18.7 mm'), ('18.3 mm', None))
    """
    if is_number(cell):
        return Stated(f"{cell} {unit}" if unit else cell)
    if not isinstance(cell, str) or len(cell) > LONGEST_NUMBER:
        return Stated(cell)
    text = cell.translate(_PLAIN).strip()
    rough = _ABOUT.match(text)
    about = cell.strip() if rough else ""
    text = text[rough.end() :] if rough else text
    if bound := _BOUND.match(text):
        side = _part(text[bound.end() :], unit)
        bounds = None if side is None else (side, None) if bound[1] in ">≥" else (None, side)
        return Stated(bounds=bounds, about=about) if bounds else Stated(cell)
    if len(sides := _PLUS_MINUS.split(text.removeprefix("(").replace(")", " ", 1) if text[:1] == "(" else text)) == 2:
        value, plus_minus = _both(sides, unit)
        return Stated(value, plus_minus, about=about or cell.strip()) if value and plus_minus else Stated(cell)
    if len(sides := _SIDES.split(text)) == 2:
        low, high = _both(sides, unit)
        return Stated(bounds=(low, high), about=about) if low and high else Stated(cell)
    return Stated(_part(text, unit) or cell, about=about)


def _both(sides: Sequence[str], unit: str | None) -> tuple[str | None, str | None]:
    """Two numbers, of which one may leave the unit to the other."""
    units = [match[2].strip() for side in sides if (match := _PART.fullmatch(side.strip()))]
    own = next(filter(None, reversed(units)), unit)
    first, second = (_part(side, own) for side in sides)
    return first, second


def _part(text: str, unit: str | None) -> str | None:
    """A number with its unit, or that of its column; None of another text."""
    match = _PART.fullmatch(text.strip())
    if match is None:
        return None
    return f"{match[1]} {match[2].strip() or unit or ''}".strip()


def exact(
    parameter: Parameter, cell: Plain, unit: str | None, where: str, materials: Collection[str] = ()
) -> tuple[Value, str]:
    """The value of a parameter, and the cell where it is no exact number; raises InvalidInput, of a range too."""
    if parameter.kind == "boolean" and isinstance(cell, str):
        return parse_value(parameter, YES_OR_NO.get(cell.strip().lower(), cell), where), ""
    if parameter.kind not in ("quantity", "integer"):
        return parse_value(parameter, cell.strip() if isinstance(cell, str) else cell, where, materials=materials), ""
    number = stated(cell, unit)
    if number.bounds is not None:
        raise refusal(where, cell, f"one value, {parameter.limit()}", "write the value that is to be compared")
    value = parse_value(parameter, number.value, where)
    if number.plus_minus is not None:
        size = Parameter(name=parameter.name, kind="quantity", unit=parameter.unit, meaning="", minimum=0.0)
        parse_value(size, number.plus_minus, where)
    return value, number.about and f"{parameter.name} {number.about}"


def yes_or_no(cell: Plain, where: str) -> bool:
    """Whether a cell says yes, or P for perforated; raises InvalidInput."""
    word = str(cell).strip().lower().removesuffix(".0")
    if word not in YES_OR_NO:
        raise refusal(where, cell, "yes or no, or P or NP", nearest_cure(cell, ("yes", "no", "P", "NP")))
    return YES_OR_NO[word]
