"""Decks of MPM3D: appendix A line by line, a bar bit for bit, and every bad deck an error with its line."""

import math
import random
import re
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from solver.matter.strength.johnson_cook import JohnsonCook
from solver.problem import Face, Problem
from solver.simulation import simulate, start
from studies.decks.reader import MOST_BYTES, read_deck, read_file_text
from studies.quantities.findings import InvalidInput
from studies.runs.run import resolve
from studies.runs.stages import setting_of
from tests.cases.verification.chapman_jouguet import STATE, at_front
from tests.cases.verification.setups.column import profile
from tests.cases.verification.solutions.detonation import TNT, chapman_jouguet
from tests.claims.rows import Row, at_most, equal, relative
from tests.samples import needs
from tests.studies.decks.texts import appendix_deck, bar_deck, detonation_deck, fluid_deck, points_deck, soil_deck

MEBIBYTE = 1 << 20
DECKS: dict[str, Callable[[], str]] = {
    "appendix": appendix_deck,
    "detonation": lambda: detonation_deck(20),
    "fluid": fluid_deck,
    "soil": soil_deck,
}


def problem(scenario: str, **parameters: Any) -> Problem:
    return setting_of(resolve(scenario, parameters)).problem


def error(text: str, units: str = "deck") -> str:
    with pytest.raises(InvalidInput) as caught:
        read_deck(text, units)
    return str(caught.value)


# --- the thesis' deck -------------------------------------------------------------------------------


@pytest.mark.claim("decks", "appendix-a", minutes=0.2)
def test_appendix__has_the_counts_that_it_states_and_keeps_its_balance(compared: Callable[[Row], None]) -> None:
    """The deck of the thesis' appendix A has its nodes and particles, and its 400 steps keep energy and momentum."""
    deck = read_deck(appendix_deck())
    assert [body.count for body in deck.bodies] == [130, 130]
    assert deck.bodies[1].rows[1][:4] == (132, 0.75e-3, 0.25e-3, 5.25e-3)
    assert len(deck.materials) == 2
    compared(equal("nodes", expected=1200, got=deck.nodes))
    compared(equal("particles", expected=260, got=deck.particles))
    outcome = simulate(problem("deck", deck=appendix_deck()))
    compared(equal("steps", expected=400, got=outcome.snapshot.step))
    compared(at_most("drift of the energy", limit=1e-10, got=abs(outcome.audit.energy_drift)))
    compared(at_most("error of the momentum", limit=1e-10, got=outcome.audit.momentum_error))


def test_appendix__becomes_the_problem_that_it_says() -> None:
    made = problem("deck", deck=appendix_deck())
    assert made.geometry.cells.tolist() == [9, 9, 11]
    assert made.geometry.spacing == 1e-3
    assert made.geometry.lower.tolist() == [0.0, 0.0, -1e-3]
    assert made.faces == ((Face.SYMMETRIC, Face.FREE),) * 3
    assert (made.fixed_dt, made.end_time) == (1e-7, 4e-5)
    assert made.contact is not None
    moving, resting = made.bodies
    # Particle 1 was stopped after its component was set in motion.
    assert moving.velocity[0].tolist() == [0.0, 0.0, 0.0]
    assert np.all(moving.velocity[1:] == (0.0, 0.0, 200.0))
    assert not resting.velocity.any()
    assert moving.mass == pytest.approx(np.full(130, 8900.0 * 1e-9 / 8.0), rel=1e-12)
    assert moving.matter.strength == JohnsonCook(90e6, 392e6, 0.5, 0.0, 1.0, 1.0)
    eos = moving.matter.eos._asdict()
    assert (eos["c0"], eos["s"]) == (3300.0, 1.49)


@needs("elastic_bar")
@pytest.mark.claim("decks", "deck-bar", minutes=0.1)
def test_bar__of_a_deck_equals_that_of_the_scenario_bit_for_bit(compared: Callable[[Row], None]) -> None:
    """The deck of the thesis' elastic bar equals its scenario bit for bit."""
    own = problem("elastic_bar", geometry="quarter", recipe="thesis", wall="symmetric", fixed_dt=1e-8)
    assert own.bodies[0].mass.size == 260
    text = bar_deck(own, young=100e9, poisson=0.3)
    first, second = (start(each) for each in (own, problem("deck", deck=text)))
    for _ in range(200):
        first.advance()
        second.advance()
    assert first.particles.pressure.any()
    differing = int((first.table != second.table).sum())
    compared(equal("numbers that differ after 200 steps", expected=0, got=differing))


@pytest.mark.claim("decks", "deto1k", minutes=1.0)
def test_detonation__of_a_deck_reaches_the_state_of_chapman_and_jouguet(compared: Callable[[Row], None]) -> None:
    """The deck of a TNT bar, MPM3D-F90's Deto1k, reaches Chapman's and Jouguet's state within 2 %."""
    cells = 1600
    line = profile(simulate(problem("deck", deck=detonation_deck(cells))).snapshot, 0)
    exact, speed = chapman_jouguet(TNT), line.place / line.time
    for name, expected, values in (
        ("pressure (GPa)", exact.pressure / 1e9, line.stress / 1e9),
        ("density (kg/m3)", exact.density, line.density),
        ("velocity (m/s)", exact.velocity, line.velocity),
    ):
        got = at_front(speed, np.asarray(values))
        compared(relative(f"TNT, {cells} cells: {name}", expected=expected, got=got, within=STATE))


# --- MPM3D-F90's decks ------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 5, 9])
def test_ball_and_disc__have_the_particles_that_are_counted(n: int) -> None:
    half = np.arange(-n, n) + 0.5
    square = half[:, None] ** 2 + half**2
    ball = int((square[:, :, None] + half**2 < n * n).sum())
    disc = int((square < n * n).sum())
    for shape, count in (("sphere", ball), ("cicle", disc)):
        text = soil_deck().replace("particle block 1", f"particle {shape} 1")
        text = text.replace("1 2.1d3 0.5 0 0 0.5 4 4 4", f"1 2.1d3 {2.5 / n!r} 3 3 3 {n}")
        text = text.replace("nbmp 64", f"nbmp {count}")
        made = problem("deck", deck=text)
        assert made.bodies[0].mass.size == count == read_deck(text).particles


def test_refinement__keeps_mass_and_outline() -> None:
    coarse, fine = (problem("deck", deck=fluid_deck(), refinement=each) for each in (1, 3))
    for one, other in zip(coarse.bodies, fine.bodies, strict=True):
        assert other.mass.size == 27 * one.mass.size
        assert math.isclose(one.mass.sum(), other.mass.sum(), rel_tol=1e-12)
        centre = (one.mass[:, None] * one.position).sum(axis=0) / one.mass.sum()
        refined = (other.mass[:, None] * other.position).sum(axis=0) / other.mass.sum()
        assert refined == pytest.approx(centre, abs=1e-15)
    assert coarse.fixed_dt is not None
    assert fine.fixed_dt == pytest.approx(coarse.fixed_dt / 3.0, rel=1e-11)


# --- errors -----------------------------------------------------------------------------------------

BLOCK = "particle block 1\n1 2.1d3 0.5 0 0 0.5 4 4 4"
GRAVITY = "load\n{}\nendl\nvelo"
# A deck, a text in it and what stands in its place; then the begin of the line that is named, and words of the error.
REFUSED = [
    ("appendix", "tstep 400", "tsetp 400", "tsetp", "'tsetp'.*tste"),
    ("appendix", "nbmp 260", "nbmp 261", "", ""),
    ("appendix", "nbgn 1200", "nbgn 1201", "nbgn", "the 1200 that the deck has"),
    ("appendix", "nmat 2", "nmat 3", "", "the 3 materials of nmat"),
    ("appendix", "spx 0.0 9.0", "spx 0.0", "spx", "the end of the line"),
    ("appendix", "fixed 2 0 2 0 2 0", "fixed 2 0 2 0 2 3", "fixed", "from 0 to 2"),
    ("appendix", "1 john 8.9d-3 100.0d3", "1 john 8.9d-3", "1 john", "numbers of john"),
    ("appendix", "seos 1 1 3.3d3 1.49 1.96", "seos 1 1 3.3d3 1.49", "seos 1", "3 or 8 numbers of form 1"),
    ("appendix", "comp 1 0.0 0.0 200.0", "comp 3 0.0 0.0 200.0", "comp 3", "a component of the deck"),
    ("appendix", "0.2500D+00", "0.2500D00+00", "1 1 1", "a number, length"),
    ("appendix", "dcell 1.0", "dcell -1.0", "", "a cell of more than 0"),
    ("appendix", "132 1 2", "132 2 2", "", "one material in each component"),
    ("detonation", "\n1 1.63d-3 1.6666666666666667 0", "\n1 9 1.6 0", "", "density of material 1"),
    ("soil", "m kg N s Pa", "ft lb s", "", "deck line 2: ft lb s"),
    ("soil", "nbmp 64", "nbmp\x00 64", "nbmp", "control character"),
    *(
        ("soil", "musl on", macro, macro, "")
        for macro in ("sgmp", "drda", "smoo", "damp 0.1", "load part 1 0 0 1 endl")
    ),
    ("soil", "0.3545 9.74d3 0.0", "0.3545 9.74d3 0.1", "1 dpm", "qpsi 0.1"),
    ("soil", "0.3545 9.74d3", "-0.3545 9.74d3", "1 dpm", "qfai of 0 or more"),
    ("soil", "musl on", "musl maybe", "musl", "write on or off"),
    ("soil", "dpm 2.1d3", "dpx 2.1d3", "1 dpx", "a kind of material"),
    ("soil", "dpm 2.1d3 0.7e8 0.3 0.3545 9.74d3 0.0 27.48d3", "neoh 1 2 3", "1 neoh", "that this solver has"),
    ("soil", "particle block", "particle brick", "particle brick", "use one of: block"),
    ("soil", "dtscale 0.2", "dtscale 5", "", "at most 2.5"),
    ("soil", "endt 0.01", "", "", "write endtime"),
    ("soil", "particle block 1\n1 2.1d3 0.5 0 0 0.5 4 4 4", "", "", "write Particle"),
    ("detonation", "deto 0 0 0", "", "1 hiex", "write deto x y z"),
    ("detonation", "seos 1 3 3.712d5 3.21d3 4.15 0.95 0.3 6993", "", "1 hiex", "hiex with no seos"),
    ("fluid", "2.2d3 0\n2 jcf", "2.2d3 1\n2 jcf", "1 null", "a fluid without viscosity"),
    ("fluid", "0.3 250 700", "0.3 250 80d3", "3 pla2", "below Young"),
    # Gravity of one body of three, of two, of none, and too short.
    ("fluid", "velo", GRAVITY.format("grav 1 0 0 -9.81"), "grav 1", ""),
    ("fluid", "velo", GRAVITY.format("grav 1 0 0 -9.81\ngrav 2 0 0 -9.81\ngrav 3 0 0 0"), "grav 3", ""),
    # Hostile sizes.
    ("soil", "4 4 4", "1000000 1000000 1000000", "", "particles that nbmp leaves"),
    ("soil", "grid 0 6 0 6 0 6", "grid 0 1d9 0 1d9 0 1d9", "", ""),
    ("soil", BLOCK, "particle sphere 1\n1 2.1d3 0.5 3 3 3 300000", "", "particles that nbmp leaves"),
    ("soil", "particle block 1", "particle point 1 1000000000\nparticle block 1", "particle point", ""),
]


@pytest.mark.parametrize(("name", "stated", "wrong", "line", "says"), REFUSED, ids=[row[2][:40] for row in REFUSED])
def test_deck__that_is_wrong_is_refused_with_its_line_before_memory_is_taken(
    name: str, stated: str, wrong: str, line: str, says: str
) -> None:
    right = DECKS[name]()
    assert stated in right
    text = right.replace(stated, wrong, 1)
    tracemalloc.start()
    message = error(text)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    number = str(next(at for at, each in enumerate(text.splitlines(), 1) if each.startswith(line))) if line else ""
    assert f"deck line {number}" in message
    assert re.search(says, message)
    assert peak < MEBIBYTE or name == "appendix"


def test_gravity__of_all_bodies_is_that_of_the_problem() -> None:
    """9.81 m/s2 are 9.81d-3 mm/ms2; a later line overrules an earlier one."""
    falls = soil_deck().replace("velo", "load\ngrav 1 0 0 -1\ngrav 1 0 0 -9.81d-3\nendl\nvelo")
    made = problem("deck", deck=falls, units="mm-g-ms", contact="none")
    assert made.gravity == (0.0, 0.0, -9.81)
    assert problem("deck", deck=soil_deck()).gravity == (0.0, 0.0, 0.0)


def test_file__has_comments_in_any_encoding_and_words_in_text() -> None:
    comment = "mpm3 title\n! 坡 Müller\n"
    for encoding in ("utf-8", "gb18030", "utf-16", "utf-8-sig"):
        text = read_file_text((comment + soil_deck()).encode(encoding))
        assert text.splitlines()[0] == "mpm3 title"
        assert read_deck(text).particles == 64
    with pytest.raises(InvalidInput, match="byte 0x81 in line 2"):
        read_file_text(b"mpm3 title\nnbmp \x81\n")


FOREIGN = {
    "LS-DYNA": "$ units: mm, ms, kg\n*KEYWORD\n*TITLE\n",
    "an LS-DYNA": "*CONTROL_TERMINATION\n 0.01\n*PART\n",
    "Abaqus": "** Job name: plate\n*Heading\n*Node\n1, 0., 0., 0.\n",
    "an Abaqus": "*Material, name=COPPER\n",
    "CTH": "*eor* genin\n*\ncontrol\n",
    "Nastran": "SOL 700\nCEND\nBEGIN BULK\n",
    "Radioss": "#RADIOSS STARTER\n/BEGIN\n",
    "Autodyn": "# AUTODYN input\n",
    "LAMMPS": "# peridynamics\nunits si\natom_style peri\n",
}


@pytest.mark.parametrize("program", FOREIGN)
def test_file__of_another_program_is_named(program: str) -> None:
    large = FOREIGN[program] + "1.0 2.0 3.0\n" * 200_000
    for content in (FOREIGN[program].encode(), large.encode(), FOREIGN[program].encode("utf-16")):
        with pytest.raises(InvalidInput, match=f"{program}.*whipple reads decks of MPM3D"):
            read_deck(read_file_text(content))


def test_deck__of_two_megabytes_is_read_and_a_larger_one_refused() -> None:
    text = points_deck(MOST_BYTES)
    assert MOST_BYTES - 100 < len(text) <= MOST_BYTES == 2_000_000
    assert read_deck(read_file_text(text.encode())).particles > 20_000
    with pytest.raises(InvalidInput, match="at most 2000000 bytes"):
        read_file_text((text + " " * 100).encode())


@pytest.mark.parametrize("name", DECKS)
def test_deck__of_exchanged_words_is_read_or_refused(name: str) -> None:
    """Whatever word stands in the place of another, nothing but InvalidInput is raised."""
    random_words = random.Random(1)
    words = [*DECKS[name]().split(), "-1", "1d400", "0", "x", "!", "99999999", "endi", ","]
    lines = DECKS[name]().splitlines()
    for _ in range(300):
        changed = list(lines)
        at = random_words.randrange(len(changed))
        row = changed[at].split() or [""]
        row[random_words.randrange(len(row))] = random_words.choice(words)
        changed[at] = " ".join(row)
        with suppress(InvalidInput):
            read_deck("\n".join(changed))
