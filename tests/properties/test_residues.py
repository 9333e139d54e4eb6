"""Proposition 1 and the commutative residues of section II-C of the paper, tried in worlds with known answers."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from tests.helpers import DOFS, EMPTY, FREE_SPACE, drive, enter, reset_world

from sensory_commutativity.scp.equivalence import (
    commutative_residue,
    commute,
    equivalent,
    is_commutative_residue,
)
from sensory_commutativity.scp.sequences import compose, inverse, no_op, sample_sequence
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

CORRIDORS = {
    "free": Corridor(),
    "wall": Corridor(wall=1),
    "box": Corridor(box=1),
    "box and wall": Corridor(wall=3, box=1),
}
every_corridor = pytest.mark.parametrize("corridor", CORRIDORS.values(), ids=list(CORRIDORS))
corridors = st.sampled_from(list(CORRIDORS.values()))


def corridor_sequences(eyelid=(0.0, -0.5, 0.5), longest: int = 5):
    """Sequences of moves and eyelid commands whose sums are exact, so that equality is no matter of rounding."""
    action = st.tuples(st.sampled_from([-1.0, 0.0, 1.0]), st.sampled_from(eyelid))
    return st.lists(action, max_size=longest).map(
        lambda actions: np.array(actions, float).reshape(-1, 2)
    )


def moves(*directions: int) -> np.ndarray:
    return np.array([(float(d), 0.0) for d in directions]).reshape(-1, 2)


def all_moves(longest: int) -> list[np.ndarray]:
    """Every sequence of steps left and right, the shortest first."""
    return [
        moves(*directions)
        for length in range(longest + 1)
        for directions in product((-1, 1), repeat=length)
    ]


LEFT, RIGHT = moves(-1), moves(1)


def from_start(world):
    """The world and its start situation, the first two arguments of everything here."""
    reset_world(world)
    return world, world.snapshot()


# ---- proposition 1.1: an equivalence ---------------------------------------------------------------------------------------


@every_corridor
def test_equivalence_over_all_short_sequences(corridor):
    """Reflexive, symmetric and transitive, checked on every pair and triple of 31 sequences."""
    where, sequences = from_start(corridor), all_moves(4)
    related = np.array([[equivalent(*where, h, g) for g in sequences] for h in sequences])
    assert related.diagonal().all()
    assert np.array_equal(related, related.T)
    assert np.array_equal(
        related @ related, related
    )  # two steps of the relation lead nowhere that one does not
    assert (
        len(sequences) < related.sum() < related.size
    )  # it tells some sequences apart and not all


@given(corridors, corridor_sequences())
def test_equivalence_is_reflexive(corridor, h):
    assert equivalent(*from_start(corridor), h, h.copy())


@given(corridors, corridor_sequences(), corridor_sequences())
@example(CORRIDORS["wall"], moves(1, 1, -1), moves(1, -1))
@example(CORRIDORS["wall"], moves(1, 1, -1), moves(-1, 1, 1))
def test_equivalence_is_symmetric(corridor, h, g):
    where = from_start(corridor)
    assert equivalent(*where, h, g) == equivalent(*where, g, h)


@given(corridors, st.permutations([(1.0, 0.0), (-1.0, 0.5), (1.0, -0.5), (-1.0, 0.0)]), st.data())
def test_equivalence_is_transitive(corridor, actions, data):
    where, h = from_start(corridor), np.array(actions)
    g, k = (np.array(data.draw(st.permutations(actions))) for _ in range(2))
    assume(equivalent(*where, h, g) and equivalent(*where, g, k))
    assert equivalent(*where, h, k)


def test_equivalence_with_a_threshold_need_not_be_transitive():
    where = from_start(Corridor())
    near = {"threshold": 0.5}  # one place apart is 1/3, two places are 4/3
    assert equivalent(*where, moves(), moves(1), **near)
    assert equivalent(*where, moves(1), moves(1, 1), **near)
    assert not equivalent(*where, moves(), moves(1, 1), **near)


@given(corridors, corridor_sequences(), corridor_sequences(), corridor_sequences())
def test_what_follows_equivalent_sequences_stays_equivalent(corridor, h, g, k):
    """In the Corridor all that matters is seen, so the relation carries over to compositions."""
    where = from_start(corridor)
    if equivalent(*where, h, g):
        assert equivalent(*where, compose(h, k), compose(g, k))


# ---- proposition 1.2: a group ----------------------------------------------------------------------------------------------


@given(corridors, corridor_sequences(), corridor_sequences(), corridor_sequences())
def test_composition_is_associative(corridor, h, g, k):
    left, right = compose(compose(h, g), k), compose(h, compose(g, k))
    assert np.array_equal(left, right)
    assert equivalent(*from_start(corridor), left, right)


@given(corridors, corridor_sequences(), st.integers(0, 4))
def test_no_op_is_the_identity(corridor, h, length):
    where, nothing = from_start(corridor), no_op(length, 2)
    assert equivalent(*where, compose(nothing, h), h)
    assert equivalent(*where, compose(h, nothing), h)


@given(corridor_sequences(longest=12))
def test_every_sequence_has_an_inverse_where_nothing_is_irreversible(h):
    where = from_start(Corridor())
    assert equivalent(*where, compose(h, inverse(h)), no_op(1, 2))
    assert equivalent(*where, compose(inverse(h), h), no_op(1, 2))


@pytest.mark.parametrize(("corridor", "h"), [("wall", moves(1, 1)), ("box", moves(1))])
def test_a_wall_or_a_box_takes_the_inverse_away(corridor, h):
    where = from_start(CORRIDORS[corridor])
    assert not equivalent(*where, compose(h, inverse(h)), no_op(1, 2))


def test_nothing_brings_the_box_back():
    where = from_start(CORRIDORS["box"])
    assert not any(equivalent(*where, compose(RIGHT, g), no_op(1, 2)) for g in all_moves(5))
    assert any(equivalent(*where, compose(LEFT, g), no_op(1, 2)) for g in all_moves(5))


@given(corridor_sequences(), corridor_sequences())
def test_a_free_corridor_is_a_commutative_group(h, g):
    assert commute(*from_start(Corridor()), h, g)


# ---- proposition 1.3: not commutative; residues ----------------------------------------------------------------------------


def test_a_wall_leaves_a_residue():
    """From place 0 with a wall behind place 1: right, right, left ends at 0, and left, right, right at 1."""
    where, first, second = from_start(Corridor(wall=1)), moves(1, 1), moves(-1)
    assert not commute(*where, first, second)
    residue = commutative_residue(*where, first, second, all_moves(3))
    assert np.array_equal(residue, LEFT)
    other_way = commutative_residue(*where, second, first, all_moves(3))
    assert np.array_equal(other_way, RIGHT)


def test_a_box_leaves_a_residue():
    """The paper's own example: right then left pushes the box, left then right does not."""
    where = from_start(Corridor(box=1))
    assert not commute(*where, RIGHT, LEFT)
    residue = commutative_residue(*where, RIGHT, LEFT, all_moves(3))
    assert np.array_equal(residue, moves(1, -1))
    assert is_commutative_residue(*where, moves(1, -1), RIGHT, LEFT)
    assert not is_commutative_residue(*where, moves(-1, 1), RIGHT, LEFT)
    assert (
        commutative_residue(*where, LEFT, RIGHT, all_moves(5)) is None
    )  # that would need the box to come back


@given(corridors, corridor_sequences(longest=3), corridor_sequences(longest=3))
def test_the_empty_sequence_is_the_residue_of_what_commutes(corridor, h, g):
    where = from_start(corridor)
    assert is_commutative_residue(*where, no_op(0, 2), h, g) == commute(*where, h, g)
    residue = commutative_residue(*where, h, g, all_moves(3))
    assert (residue is not None and len(residue) == 0) == commute(*where, h, g)


@given(corridors, corridor_sequences(longest=4), corridor_sequences(longest=4))
def test_a_found_residue_is_one(corridor, h, g):
    where = from_start(corridor)
    residue = commutative_residue(*where, h, g, all_moves(4))
    if residue is not None:
        assert equivalent(*where, compose(h, g), compose(g, h, residue))


def test_residues_are_tried_in_the_order_given():
    where, tried = from_start(Corridor(wall=1)), []

    def candidates():
        for residue in all_moves(5):
            tried.append(residue)
            yield residue

    assert commutative_residue(*where, moves(1, 1), LEFT, candidates()) is tried[-1]
    assert len(tried) == 2  # the empty one, then left: the search stops there


def test_keywords_are_passed_on():
    where = from_start(Corridor(wall=1))
    apart = {"distance": lambda a, b: abs(a[0] - b[0])}  # places apart: 1
    assert not commute(*where, moves(1, 1), LEFT, threshold=0.9, **apart)
    assert commute(*where, moves(1, 1), LEFT, threshold=1.0, **apart)
    assert (
        len(commutative_residue(*where, moves(1, 1), LEFT, all_moves(3), threshold=1.0, **apart))
        == 0
    )
    assert is_commutative_residue(*where, no_op(0, 2), moves(1, 1), LEFT, threshold=1.0, **apart)


# ---- Philipona's conjecture ------------------------------------------------------------------------------------------------


@given(
    corridors,
    st.lists(st.sampled_from([-1.0, 1.0]), max_size=6),
    st.lists(st.sampled_from([-1.0, -0.5, 0.5, 1.0]), max_size=6),
)
def test_the_eyelid_commutes_with_moves(corridor, places, lids):
    h = np.array([(place, 0.0) for place in places]).reshape(-1, 2)
    g = np.array([(0.0, lid) for lid in lids]).reshape(-1, 2)
    assert commute(*from_start(corridor), h, g)


def test_displacements_need_not_commute():
    h, g = moves(1, 1), moves(-1)
    assert {name: commute(*from_start(corridor), h, g) for name, corridor in CORRIDORS.items()} == {
        "free": True,
        "wall": False,
        "box": False,
        "box and wall": False,
    }


# ---- Flatland --------------------------------------------------------------------------------------------------------------


def one_at_a_time(seed: int, length: int = 12) -> np.ndarray:
    """A sequence in which each action commands one degree of freedom."""
    rng = np.random.default_rng(seed)
    sequence = np.zeros((length, 8))
    sequence[np.arange(length), rng.integers(0, 8, length)] = rng.uniform(-1, 1, length)
    return sequence


@pytest.mark.parametrize("seed", range(5))
def test_flatland_equivalence_in_free_space(seed):
    where, h, g = (
        from_start(FlatlandWorld(FREE_SPACE)),
        one_at_a_time(seed),
        one_at_a_time(seed + 100),
    )
    assert equivalent(*where, h, h)
    assert equivalent(*where, compose(no_op(3, 8), h), h)
    assert equivalent(*where, compose(h, no_op(3, 8)), h)
    assert equivalent(*where, compose(h, inverse(h)), no_op(1, 8))
    assert equivalent(*where, compose(compose(h, g), h), compose(h, compose(g, h)))
    assert not equivalent(
        *where,
        compose(h, drive("left-shoulder", 1.0, 3)),
        compose(h, drive("left-shoulder", -1.0, 3)),
    )


@pytest.mark.parametrize("dof", DOFS)
def test_flatland_has_inverses_in_an_empty_room(dof):
    """Away from its walls. Two seeds per degree of freedom."""
    world = FlatlandWorld(EMPTY)
    for seed in range(2):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        h = sample_sequence(rng, 20, DOFS.index(dof), 8)
        assert equivalent(world, world.snapshot(), compose(h, inverse(h)), no_op(1, 8))


def against_the_wall():
    """With its back 182 units from a wall, looking at the wall and the corners on the other side."""
    world = enter(EMPTY, 300, 212, math.pi / 2)
    return world, world.snapshot()


def test_flatland_s_wall_takes_the_inverse_away():
    where, h = against_the_wall(), drive("base-longitudinal", -1.0, 35)
    assert not equivalent(*where, compose(h, inverse(h)), no_op(1, 8))
    short = drive("base-longitudinal", -1.0, 15)
    assert equivalent(*where, compose(short, inverse(short)), no_op(1, 8))


def test_flatland_s_wall_leaves_a_residue():
    """Back for 40 steps of 8 units and ahead for 25: the wall swallows 320 - 182 units in one order and none in the other."""
    where = against_the_wall()
    back, ahead = drive("base-longitudinal", -1.0, 40), drive("base-longitudinal", 1.0, 25)
    assert not commute(*where, back, ahead)
    candidates = [drive("base-longitudinal", 1.0, steps) for steps in range(31)]
    residue = commutative_residue(*where, back, ahead, candidates)
    assert residue is not None
    assert abs(8 * len(residue) - 138) < 48  # 64 pixels: places a few steps apart look alike
    assert (
        commutative_residue(
            *where, back, ahead, [drive("base-longitudinal", -1.0, steps) for steps in range(10)]
        )
        is None
    )


def test_flatland_s_movable_thing_does_not_commute():
    """A box ahead, pushed in one order and left alone in the other."""
    box = {"vertices": 4, "radius": 25.0, "kind": 1, "colour": (255, 0, 0), "pose": (480, 400, 0.3)}
    world = enter(EMPTY, 300, 400, 0.0, [box])
    where = world, world.snapshot()
    ahead, back = drive("base-longitudinal", 1.0, 20), drive("base-longitudinal", -1.0, 20)
    assert not commute(*where, ahead, back)
    assert commutative_residue(*where, ahead, back, [no_op(0, 8), ahead, back]) is None
    assert commute(
        *where, drive("base-longitudinal", 1.0, 12), drive("base-longitudinal", -1.0, 12)
    )  # 33 units short of the box
