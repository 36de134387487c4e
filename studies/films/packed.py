"""Points with colours in few bytes, for a screen: frames of one run, as its pages draw them.

A packed view holds, little-endian: the length of a text (uint32), the text, which is JSON,
and then for all frames one after the other ``position`` (components, n) of 16 bits in the box from ``low`` to ``high``
(m), ``body`` (n,) of 8 bits, and the fields (fields, n) of 8 bits between their own ``low`` and ``high``, in which
``UNKNOWN`` is a value that is not known. The last component of a position is the one along the line of flight, and
grows in the direction in which a projectile flies.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.quantities.display import display_alone
from studies.quantities.parameters import Plain
from studies.sections.radiograph import AREAL_DENSITY
from studies.sections.section import UNITS

MOST_BYTES = 8 << 20  # of the arrays of a view, before compression
MOST_FRAMES = 60  # more than a slider of 300 pixels can tell apart are left out, evenly
STEPS, LEVELS, UNKNOWN = 65535, 254, 255
# Share of the values (and of the places) beyond each end of the colours (and of the window): single particles that
# have run away set neither.
STRAY = 0.005
LOGARITHMIC = frozenset({AREAL_DENSITY})  # thin matter beside a plate that is seen edge on


@dataclass(frozen=True)
class FrameOfPoints:
    """Points at one time."""

    time: float  # s
    position: np.ndarray  # (n, 2 or 3) m, the last component along the flight
    body: np.ndarray  # (n,) index
    fields: Mapping[str, np.ndarray]  # (n,) by the names of UNITS, SI; NaN where a value is not known


@dataclass(frozen=True)
class View:
    """Frames of points, and how they are to be drawn."""

    bodies: tuple[str, ...]
    width: tuple[float, ...]  # of a point of each body, m; 0: as small as can be seen
    mirrored: bool  # whether the other side of the axis is the mirror image
    frames: tuple[FrameOfPoints, ...]
    note: str  # what was left out, and what a point stands for


def packed(view: View) -> bytes:
    """The bytes of a view, thinned evenly where they would be too many; without frames its note alone."""
    if not view.frames:
        return _headed({"note": view.note, "times": []})
    view = _thinned(view)
    frames = view.frames
    position = np.concatenate([frame.position for frame in frames])
    low, high = position.min(axis=0), position.max(axis=0)
    place = np.rint((position - low) / np.maximum(high - low, 1e-300) * STEPS).astype("<u2")
    fields = [_field(name, np.concatenate([frame.fields[name] for frame in frames])) for name in frames[0].fields]
    window = np.quantile(position, [STRAY, 1.0 - STRAY], axis=0)
    text: dict[str, Plain] = {
        "bodies": view.bodies,
        "width": view.width,
        "mirrored": view.mirrored,
        "note": view.note,
        "times": [frame.time for frame in frames],
        "counts": [len(frame.body) for frame in frames],
        "low": low.tolist(),
        "high": high.tolist(),
        "window": window.tolist(),
        "fields": [about for about, _ in fields],
    }
    body = np.concatenate([frame.body for frame in frames]).astype(np.uint8)
    return _headed(text, place.T, body, *(levels for _, levels in fields))


def _headed(text: Mapping[str, Plain], *arrays: np.ndarray) -> bytes:
    head = json.dumps(text, allow_nan=False).encode()
    head += b" " * (-len(head) % 4)  # arrays of 16 bits begin at an even place
    return len(head).to_bytes(4, "little") + head + b"".join(array.tobytes() for array in arrays)


def _field(name: str, values: np.ndarray) -> tuple[dict[str, Plain], np.ndarray]:
    """A field in 8 bits, and what a legend says of it."""
    is_log = name in LOGARITHMIC
    values = np.log10(values) if is_log else values
    known = np.isfinite(values)
    low, high = np.quantile(values[known], [STRAY, 1.0 - STRAY]) if known.any() else (0.0, 0.0)
    below, above = int((values < low).sum()), int((values > high).sum())
    share = np.clip((np.where(known, values, low) - low) / max(high - low, 1e-300), 0.0, 1.0)
    levels = np.where(known, np.rint(share * LEVELS), UNKNOWN).astype(np.uint8)
    ends = [10.0**end if is_log else float(end) for end in (low, high)]
    display = display_alone(max(map(abs, ends)), UNITS[name])
    about = {
        "name": name,
        "label": name.replace("_", " "),
        "unit": display.unit,
        "low": ends[0] * display.factor,
        "high": ends[1] * display.factor,
        "logarithmic": is_log,
        "beyond": f"The colours end at the outer {100 * STRAY:g} % of values: of {known.sum()}, {below} lie below and "
        f"{above} above."
        if below + above
        else "",
    }
    return about, levels


def _thinned(view: View) -> View:
    """A view with as many frames and points as it may have; what is left out is evenly so, and its note says it."""
    frames: Sequence[FrameOfPoints] = view.frames
    notes = [view.note]
    if len(frames) > MOST_FRAMES:
        chosen = np.unique(np.linspace(0, len(frames) - 1, MOST_FRAMES).round().astype(int))
        frames = [frames[number] for number in chosen]
        notes.append(f"{MOST_FRAMES} of {len(view.frames)} frames are shown.")
    bytes_of_point = 2 * frames[0].position.shape[1] + 1 + len(frames[0].fields)
    count = sum(len(frame.body) for frame in frames)
    stride = -(-count * bytes_of_point // MOST_BYTES)
    width = view.width
    if stride > 1:
        frames = [
            replace(
                frame,
                position=frame.position[::stride],
                body=frame.body[::stride],
                fields={name: values[::stride] for name, values in frame.fields.items()},
            )
            for frame in frames
        ]
        width = tuple(size * math.sqrt(stride) for size in width)
        notes.append(f"One of {stride} particles is shown, larger in proportion.")
    return replace(view, frames=tuple(frames), width=width, note=" ".join(filter(None, notes)))
