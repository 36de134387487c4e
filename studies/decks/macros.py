"""Tables of the decks of MPM3D: units, kinds of materials, equations of state, what is refused."""

from collections.abc import Mapping
from typing import Literal

from studies.decks.deck import MOST_NODES, MOST_PARTICLES, Units

DeckQuantity = Literal[
    "length",
    "time",
    "mass",
    "velocity",
    "density",
    "stress",
    "rate",
    "number",
    "heat capacity",
    "temperature",
    "viscosity",
    "acceleration",
]

# Powers of ten to SI, where they are not 0. N = g mm / ms^2 and MPa = N / mm^2 go with mm, g, ms; energies per volume
# are stresses.
SHIFTS: Mapping[Units, Mapping[DeckQuantity, int]] = {
    "mm-g-ms": {
        **dict.fromkeys(("length", "time", "mass"), -3),
        **dict.fromkeys(("rate", "viscosity", "acceleration"), 3),
        **dict.fromkeys(("density", "stress"), 6),
    },
    "SI": {},
}

MaterialForm = Mapping[str, DeckQuantity]
ELASTIC: MaterialForm = {"density": "density", "young": "stress", "poisson": "number"}
YIELD: MaterialForm = {**ELASTIC, "yield": "stress"}
HARDENING: MaterialForm = {**YIELD, "B": "stress", "n": "number", "C": "number"}
SIMPLE: MaterialForm = {**HARDENING, "epso": "rate"}
THERMAL: MaterialForm = {
    **HARDENING,
    "m": "number",
    "room": "temperature",
    "melt": "temperature",
    "specific heat": "heat capacity",
    "epso": "rate",
}
FAILS: MaterialForm = {"epf": "number"}

# Forms of each kind, told apart by the count of their numbers; none: nothing like it here.
KINDS: Mapping[str, tuple[MaterialForm, ...]] = {
    "elas": (ELASTIC,),
    "pla1": (YIELD,),
    "pla2": ({**YIELD, "tangent": "stress"},),
    "john": (HARDENING, THERMAL),  # the thesis', and MPM3D-F90's
    "sjc": (SIMPLE,),
    "sjcf": ({**SIMPLE, **FAILS},),
    "jcf": ({**THERMAL, **FAILS},),
    "hiex": ({"density": "density", "D": "velocity"},),
    "null": (
        {"density": "density", "wave speed": "velocity"},
        {"density": "density", "bulk": "stress", "viscosity": "viscosity"},
    ),
    "dpm": ({**ELASTIC, "qfai": "number", "kfai": "stress", "qpsi": "number", "tenf": "stress"},),
    "neoh": (),
}

# Numbers of each equation of state, by name, form in ``seos`` and their count.
EOS_COUNTS: Mapping[tuple[str, int, int], tuple[DeckQuantity, ...]] = {
    ("gruneisen", 1, 3): ("velocity", "number", "number"),  # the thesis'
    ("polynomial", 1, 8): (*("stress",) * 4, *("number",) * 3, "stress"),
    ("gruneisen", 2, 3): ("velocity", "number", "number"),
    ("gruneisen", 2, 4): ("velocity", "number", "number", "stress"),
    ("jwl", 3, 6): ("stress", "stress", "number", "number", "number", "stress"),
}

# Quantities to write: MPM3D-F90's, and the thesis' strain energy.
OPTIONS = (
    *("seqv", "epef", "mat", "pres", "volu", "engk", "engi", "engs", "velx", "vely", "velz"),
    *("cels", "fail", "sspd", "damg", "stsx", "disx", "disy", "disz"),
)

# Counts that a macro gives, and the most that each may say.
COUNTS = {
    **dict.fromkeys(("nmat", "nbco", "ncom", "nbbo"), 100_000),
    "nbmp": MOST_PARTICLES,
    "nbgn": MOST_NODES,
    "ppc": 216,
    **dict.fromkeys(("tste", "oste"), 1_000_000_000),
}

# Numbers that a macro gives.
SETTINGS: Mapping[str, tuple[DeckQuantity, ...]] = {
    **dict.fromkeys(("spx", "spy", "spz"), ("length", "length")),
    "dcel": ("length",),
    **dict.fromkeys(("dt", "endt", "outt"), ("time",)),
    "dtsc": ("number",),
    "bulk": ("number", "number"),
}

# Shape functions that a macro chooses, and macros without effect here, with their numbers.
SHAPES = {"gimp": "gimp", "bimp": "quadratic-bspline"}
IGNORED: Mapping[str, tuple[DeckQuantity, ...]] = {"pt2d": ("length",) * 6, "tecp": (), "para": (), "rptt": ("time",)}

TITLES = {"nbmp": "number of particles", "nmat": "number of materials"}

# Macros of MPM3D-F90 that change the mechanics and have nothing like it here: what is allowed, and the cure.
REFUSED: Mapping[str, tuple[str, str]] = {
    "sgmp": ("linear, GIMP or B-spline shape functions", "write bimp or gimp"),
    "smoo": ("stress without smoothing on the grid", "remove it"),
    "tlmp": ("particles in the updated Lagrangian description", "remove it"),
    "uvfp": ("a volume from the velocity gradient", "remove it"),
    "qulo": ("no slowly applied loads", "remove it"),
    "damp": ("no damping of all motion", "remove it"),
    "drda": ("no dynamic relaxation", "remove it"),
}
