"""Bodies that no sweep is, each made to cost its reader as much as it can, up to the limit of a body."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from service.api.dependencies import LONGEST_BODY

JSON, YAML = "application/json", "application/yaml"
SWEEP = b'{"scenario": "thin_plate", "axes": {"speed": ["6 km/s"]}, "resolution": 8, '
THIN_PLATE = b"scenario: thin_plate\nresolution: 8\naxes: {speed: [6 km/s]}\n"
FEW, MANY = 3_000, 200_000  # members of a mapping
MOST_MAPPINGS = 90_000  # that are still read


@dataclass(frozen=True)
class CostlyBody:
    """What is sent: its media type, and how its bytes are made."""

    media_type: str
    make: Callable[[], bytes]


def filled(begin: bytes, piece: bytes, end: bytes, size: int = LONGEST_BODY) -> Callable[[], bytes]:
    """So many times the piece that a body of this size comes out."""
    return lambda: begin + piece * ((size - len(begin) - len(end)) // len(piece)) + end


def numbered(begin: bytes, piece: bytes, end: bytes, count: int) -> Callable[[], bytes]:
    """The piece so many times with a number in it, up to the limit of a body."""

    def make() -> bytes:
        pieces = b"".join(piece % number for number in range(count))
        room = LONGEST_BODY - len(begin) - len(end)
        whole = pieces if len(pieces) <= room else pieces[: pieces.rindex(piece[-1:], 0, room) + 1]
        return begin + whole + end

    return make


def plain(body: bytes) -> Callable[[], bytes]:
    """The body itself."""
    return lambda: body


def observed(begin: str, piece: str, end: str = "") -> Callable[[], bytes]:
    """A sweep with a table of observations as text."""
    return filled(SWEEP + f'"observations": "{begin}'.encode(), piece.encode(), f'{end}"}}'.encode())


MATERIALS = numbered(b'{"scenario": "thin_plate", "materials": {', b'"m%d":{"x":1},', b'"m":1}}', FEW)
REFUSED_POINTS = (
    b'{"scenario": "thin_plate", "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", '
    b'"projectile_diameter": "6 mm", "plate_thickness": "10 um"}, "resolution": 8, "axes": {"speed": '
    b'{"start": "1000 m/s", "stop": "10980 m/s", "step": "10 m/s"}, "obliquity": ["0 deg", "1 deg", "2 deg"]}}'
)
LAUGHS = b"a0: &a0 [ha, ha]\n" + b"".join(
    b"a%d: &a%d [*a%d, *a%d]\n" % (layer, layer, layer - 1, layer - 1) for layer in range(1, 90)
)

IN_JSON: Mapping[str, Callable[[], bytes]] = {
    "3 000 materials": MATERIALS,
    "unknown parameters": numbered(SWEEP + b'"fixed": {', b'"plate_thicknes%d":1,', b'"x":1}}', MANY),
    "unknown axes": numbered(b'{"scenario": "thin_plate", "axes": {', b'"a%d":1,', b'"x":1}}', 300_000),
    "refused points": plain(REFUSED_POINTS),
    "yield stresses": filled(SWEEP + b'"materials": {"m": {"yield_stresses": [', b"1,", b"1]}}}"),
    "a key twice, at the end": numbered(b"{", b'"key%d":1,', b'"z":1,"z":1}', MANY),
    "deep lists": filled(b"", b"[", b""),
    "deep mappings": filled(b"", b'{"a":', b""),
    "numbers": filled(b"[", b"1,", b"1]"),
    "empty lists": filled(b"[", b"[],", b"1]"),
    "integer of 4 MB": filled(SWEEP + b'"offsets": ', b"9", b"}"),
    "numbers that are none": filled(b'{"scenario": "thin_plate", "axes": {"speed": [', b"NaN,", b"1]}}"),
    "scenario of 4 MB": filled(b'{"scenario": "', b"thin_plate ", b'"}'),
    "key of 4 MB": filled(b'{"materials": {"', b"m.", b'": {}}}'),
    "NUL": filled(b'{"scenario": ["', b"\\u0000", b'"]}'),
    "halves of characters": filled(b'{"scenario": ["', b'\\ud800","', b'"]}'),
    "axis of 4 MB": filled(b'{"scenario": "thin_plate", "axes": {"speed": [', b'"6 km/s",', b"1]}}"),
    "axis of one material": filled(b'{"scenario": "thin_plate", "axes": {"target": [', b'"copper-ofhc",', b"1]}}"),
    "range of 1e400 steps": plain(
        b'{"scenario": "thin_plate", "axes": {"speed": '
        b'{"start": "1e-190 m/s", "stop": "1e199 m/s", "step": "1e-199 m/s"}}}'
    ),
    "unit of letters": plain(SWEEP + b'"fixed": {"plate_thickness": "1 ' + b"a" * 60 + b'!"}}'),
    "column of blanks": plain(SWEEP + b'"observations": "a[' + b" " * 130_000 + b'x\\n1"}'),
    "columns": observed("speed", ",speed", "\\n1"),
    "empty lines": observed("quantity,value,source", "\\n"),
    "cell of digits": filled(SWEEP + b'"observations": [{"value": "', b"1", b'x"}]}'),
    "shots": numbered(SWEEP + b'"observations": [', b'{"a":%d},', b'{"b":1}]}', MOST_MAPPINGS),
    "9 000 wrong shots": numbered(
        SWEEP + b'"observations": [', b'{"quantity":%d,"vlaue":"1 mm"},', b'{"b":1}]}', 9_000
    ),
    "no UTF-8": filled(b'{"name": "', b"n", b'\xff"}'),
    "no end": filled(b"[", b'"a",', b""),
    "more than the limit": filled(b"[", b"1,", b"1]", 2 * LONGEST_BODY),
}
IN_YAML: Mapping[str, Callable[[], bytes]] = {
    "laughs": plain(LAUGHS),
    "numbers in brackets": filled(b"a: [", b"1,", b"1]"),
    "200 kB of keys": numbered(b"", b"key%d: 1\n", b"", 15_000),
    "a key twice": numbered(b"", b"key%d: 1\n", b"key7: 1\n", FEW),
    "deep lists": filled(b"a: ", b"[", b""),
    "deep rows": filled(b"", b"- ", b"1"),
    "sexagesimal integer": filled(THIN_PLATE + b"offsets: 1", b":1", b""),
    "sexagesimal number": plain(THIN_PLATE + b"offsets: 1" + b":1" * 300 + b".5\n"),
    "binary integer": filled(THIN_PLATE + b"offsets: 0b", b"1", b""),
    "tag without value": plain(THIN_PLATE + b'offsets: !!int ""\n'),
    "foreign tag": plain(THIN_PLATE + b"offsets: !!python/object/apply:os.system [ls]\n"),
    "comments": filled(THIN_PLATE, b"#\n", b"x: 1"),
    "no end": filled(b'a: "', b"b ", b""),
    "merges": numbered(b"", b"<<: {a%d: 1}\n", b"", FEW),
    "directives": filled(b"", b"%TAG !a! tag:b,2000:\n", b"---\na: 1"),
}
BODIES: Mapping[str, CostlyBody] = {
    f"{word}: {name}": CostlyBody(media_type, make)
    for word, media_type, bodies in (("JSON", JSON, IN_JSON), ("YAML", YAML, IN_YAML))
    for name, make in bodies.items()
}
