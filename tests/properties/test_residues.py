"""Proposition 1 and the commutative residues of section II-C of the paper.

They are tested in worlds with known answers.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from hypothesis import assume, example, given
from hypothesis import strategies as st

from sensory_commutativity.scp.equivalence import (
    commutative_residue,
    commute,
    equivalent,
    is_commutative_residue,
)
from sensory_commutativity.scp.sequences import compose, inverse, no_op, sample_sequence
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.room import MOVABLE
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import DOFS, EMPTY, FREE_SPACE, drive, make_world, reset_world

CORRIDORS = {
    "free": Corridor(),
    "wall": Corridor(wall=1),
    "box": Corridor(box=1),
    "box and wall": Corridor(wall=3, box=1),
}
corridors = st.sampled_from(list(CORRIDORS.values()))


def corridor_sequences(max_size: int = 5):
    """Sequences whose sums are exact: equality does not depend on rounding."""
    action = st.tuples(st.sampled_from([-1.0, 0.0, 1.0]), st.sampled_from([0.0, -0.5, 0.5]))
    return st.lists(action, max_size=max_size).map(
        lambda actions: np.array(actions, float).reshape(-1, 2)
    )


def moves(*directions: int) -> np.ndarray:
    return np.array([(float(d), 0.0) for d in directions]).reshape(-1, 2)


def all_moves(max_length: int) -> list[np.ndarray]:
    """Every sequence of steps left and right, shortest first."""
    return [
        moves(*directions)
        for length in range(max_length + 1)
        for directions in product((-1, 1), repeat=length)
    ]


LEFT, RIGHT = moves(-1), moves(1)


def at_start(world):
    """The world and its start situation, the first two arguments of all functions."""
    reset_world(world)
    return world, world.snapshot()


# ---- proposition 1.1: an equivalence -------------------------------------------------------------


def test_equivalence_over_all_short_sequences():
    """Reflexive, symmetric and transitive on all pairs and triples of 31 sequences."""
    sequences = all_moves(4)
    for name, corridor in CORRIDORS.items():
        start = at_start(corridor)
        related = np.array([[equivalent(*start, h, g) for g in sequences] for h in sequences])
        assert related.diagonal().all(), name
        assert np.array_equal(related, related.T), name
        assert np.array_equal(related @ related, related), name  # transitive
        assert len(sequences) < related.sum() < related.size, name  # not trivial


@given(corridors, corridor_sequences(), corridor_sequences())
@example(CORRIDORS["wall"], moves(1, 1, -1), moves(1, -1))
@example(CORRIDORS["wall"], moves(1, 1, -1), moves(-1, 1, 1))
def test_equivalence_is_reflexive_and_symmetric(corridor, h, g):
    start = at_start(corridor)
    assert equivalent(*start, h, h.copy())
    assert equivalent(*start, h, g) == equivalent(*start, g, h)


@given(corridors, st.permutations([(1.0, 0.0), (-1.0, 0.5), (1.0, -0.5), (-1.0, 0.0)]), st.data())
def test_equivalence_is_transitive(corridor, actions, data):
    start, h = at_start(corridor), np.array(actions)
    g, k = (np.array(data.draw(st.permutations(actions))) for _ in range(2))
    assume(equivalent(*start, h, g) and equivalent(*start, g, k))
    assert equivalent(*start, h, k)


def test_equivalence_with_a_threshold_need_not_be_transitive():
    start = at_start(Corridor())
    near = {"threshold": 0.5}  # the distance of adjacent cells is 1/3, of the next ones 4/3
    assert equivalent(*start, moves(), moves(1), **near)
    assert equivalent(*start, moves(1), moves(1, 1), **near)
    assert not equivalent(*start, moves(), moves(1, 1), **near)


@given(corridors, corridor_sequences(), corridor_sequences(), corridor_sequences())
def test_equivalence_is_kept_by_composition(corridor, h, g, k):
    """The state of a corridor is fully observed, so the relation carries over."""
    start = at_start(corridor)
    if equivalent(*start, h, g):
        assert equivalent(*start, compose(h, k), compose(g, k))


# ---- proposition 1.2: a group --------------------------------------------------------------------


@given(corridors, corridor_sequences(), corridor_sequences(), corridor_sequences())
def test_composition_is_associative(corridor, h, g, k):
    left, right = compose(compose(h, g), k), compose(h, compose(g, k))
    assert np.array_equal(left, right)
    assert equivalent(*at_start(corridor), left, right)


@given(corridors, corridor_sequences(), st.integers(0, 4))
def test_no_op_is_the_identity(corridor, h, length):
    start, identity = at_start(corridor), no_op(length, 2)
    assert equivalent(*start, compose(identity, h), h)
    assert equivalent(*start, compose(h, identity), h)


@given(corridor_sequences(max_size=12), corridor_sequences())
def test_a_free_corridor_is_a_commutative_group(h, g):
    start = at_start(Corridor())
    assert equivalent(*start, compose(h, inverse(h)), no_op(1, 2))
    assert equivalent(*start, compose(inverse(h), h), no_op(1, 2))
    assert commute(*start, h, g)


def test_a_wall_or_a_box_breaks_the_inverse():
    for corridor, h in [("wall", moves(1, 1)), ("box", moves(1))]:
        start = at_start(CORRIDORS[corridor])
        assert not equivalent(*start, compose(h, inverse(h)), no_op(1, 2)), corridor


def test_no_sequence_brings_the_box_back():
    start = at_start(CORRIDORS["box"])
    assert not any(equivalent(*start, compose(RIGHT, g), no_op(1, 2)) for g in all_moves(5))
    assert any(equivalent(*start, compose(LEFT, g), no_op(1, 2)) for g in all_moves(5))


# ---- proposition 1.3: not commutative; residues --------------------------------------------------


def test_a_wall_leaves_a_residue():
    """Right, right, left ends in cell 0 (the wall is behind cell 1); left, right, right in 1."""
    start, first, second = at_start(Corridor(wall=1)), moves(1, 1), moves(-1)
    assert not commute(*start, first, second)
    assert np.array_equal(commutative_residue(*start, first, second, all_moves(3)), LEFT)
    assert np.array_equal(commutative_residue(*start, second, first, all_moves(3)), RIGHT)


def test_a_box_leaves_a_residue():
    """The paper's own example: right then left pushes the box, left then right does not."""
    start = at_start(Corridor(box=1))
    assert not commute(*start, RIGHT, LEFT)
    assert np.array_equal(commutative_residue(*start, RIGHT, LEFT, all_moves(3)), moves(1, -1))
    assert is_commutative_residue(*start, moves(1, -1), RIGHT, LEFT)
    assert not is_commutative_residue(*start, moves(-1, 1), RIGHT, LEFT)
    # the opposite residue would have to bring the box back
    assert commutative_residue(*start, LEFT, RIGHT, all_moves(5)) is None


@given(corridors, corridor_sequences(max_size=4), corridor_sequences(max_size=4))
def test_residues_fulfil_their_definition(corridor, h, g):
    """The residue is empty if and only if the sequences commute."""
    start = at_start(corridor)
    assert is_commutative_residue(*start, no_op(0, 2), h, g) == commute(*start, h, g)
    residue = commutative_residue(*start, h, g, all_moves(4))
    if residue is not None:
        assert equivalent(*start, compose(h, g), compose(g, h, residue))
    assert (residue is not None and len(residue) == 0) == commute(*start, h, g)


def test_the_search_stops_at_the_first_residue():
    start, candidates = at_start(Corridor(wall=1)), []

    def iterate_candidates():
        for residue in all_moves(5):
            candidates.append(residue)
            yield residue

    residue = commutative_residue(*start, moves(1, 1), LEFT, iterate_candidates())
    assert residue is candidates[-1]
    assert len(candidates) == 2  # the empty sequence, then left


def test_keywords_are_passed_on():
    start = at_start(Corridor(wall=1))
    apart = {"distance": lambda a, b: abs(a[0] - b[0])}  # in cells: 1
    strict, loose = {**apart, "threshold": 0.9}, {**apart, "threshold": 1.0}
    assert not commute(*start, moves(1, 1), LEFT, **strict)
    assert commute(*start, moves(1, 1), LEFT, **loose)
    assert len(commutative_residue(*start, moves(1, 1), LEFT, all_moves(3), **loose)) == 0
    assert is_commutative_residue(*start, no_op(0, 2), moves(1, 1), LEFT, **loose)


# ---- Philipona's conjecture ----------------------------------------------------------------------


@given(
    corridors,
    st.lists(st.sampled_from([-1.0, 1.0]), max_size=6),
    st.lists(st.sampled_from([-1.0, -0.5, 0.5, 1.0]), max_size=6),
)
def test_the_eyelid_commutes_with_moves(corridor, directions, eyelid_actions):
    h = np.array([(direction, 0.0) for direction in directions]).reshape(-1, 2)
    g = np.array([(0.0, action) for action in eyelid_actions]).reshape(-1, 2)
    assert commute(*at_start(corridor), h, g)


def test_displacements_need_not_commute():
    h, g = moves(1, 1), moves(-1)
    commuting = {name: commute(*at_start(corridor), h, g) for name, corridor in CORRIDORS.items()}
    assert commuting == {"free": True, "wall": False, "box": False, "box and wall": False}


# ---- Flatland ------------------------------------------------------------------------------------


def sample_mixed_sequence(seed: int, length: int = 12) -> np.ndarray:
    """A sequence in which each action commands one degree of freedom."""
    rng = np.random.default_rng(seed)
    sequence = np.zeros((length, 8))
    sequence[np.arange(length), rng.integers(0, 8, length)] = rng.uniform(-1, 1, length)
    return sequence


def test_flatland_equivalence_in_free_space():
    for seed in range(5):
        start = at_start(FlatlandWorld(FREE_SPACE))
        h, g = sample_mixed_sequence(seed), sample_mixed_sequence(seed + 100)
        assert equivalent(*start, h, h)
        assert equivalent(*start, compose(no_op(3, 8), h), h)
        assert equivalent(*start, compose(h, no_op(3, 8)), h)
        assert equivalent(*start, compose(h, inverse(h)), no_op(1, 8))
        assert equivalent(*start, compose(compose(h, g), h), compose(h, compose(g, h)))
        left, right = (compose(h, drive("left-shoulder", value, 3)) for value in (1.0, -1.0))
        assert not equivalent(*start, left, right)


def test_flatland_has_inverses_away_from_walls():
    world = FlatlandWorld(EMPTY)
    for k, dof in enumerate(DOFS):
        for seed in range(2):
            rng = np.random.default_rng(seed)
            world.reset(rng)
            h = sample_sequence(rng, 20, k, 8)
            assert equivalent(world, world.snapshot(), compose(h, inverse(h)), no_op(1, 8)), dof


def back_to_the_wall():
    """The agent's back is 182 units from a wall; it looks at the opposite wall and its corners."""
    world = make_world(EMPTY, 300, 212, math.pi / 2)
    return world, world.snapshot()


def test_a_wall_of_flatland_breaks_the_inverse():
    start, h = back_to_the_wall(), drive("base-longitudinal", -1.0, 35)
    assert not equivalent(*start, compose(h, inverse(h)), no_op(1, 8))
    short = drive("base-longitudinal", -1.0, 15)
    assert equivalent(*start, compose(short, inverse(short)), no_op(1, 8))


def test_a_wall_of_flatland_leaves_a_residue():
    """Back for 40 steps of 8 units and ahead for 25.

    In one order, the wall blocks 320 - 182 units; in the other, none.
    """
    start = back_to_the_wall()
    back, ahead = drive("base-longitudinal", -1.0, 40), drive("base-longitudinal", 1.0, 25)
    assert not commute(*start, back, ahead)
    forwards = [drive("base-longitudinal", 1.0, steps) for steps in range(31)]
    residue = commutative_residue(*start, back, ahead, forwards)
    assert residue is not None
    assert abs(8 * len(residue) - 138) < 48  # with 64 pixels, poses a few steps apart look alike
    backwards = [drive("base-longitudinal", -1.0, steps) for steps in range(10)]
    assert commutative_residue(*start, back, ahead, backwards) is None


def test_a_movable_object_of_flatland_does_not_commute():
    """A box ahead is pushed in one order and not touched in the other."""
    box = {"vertices": 4, "radius": 25.0, "colour": (255, 0, 0), "pose": (480, 400, 0.3)}
    world = make_world(EMPTY, 300, 400, 0.0, [{**box, "kind": MOVABLE}])
    start = world, world.snapshot()
    ahead, back = drive("base-longitudinal", 1.0, 20), drive("base-longitudinal", -1.0, 20)
    assert not commute(*start, ahead, back)
    assert commutative_residue(*start, ahead, back, [no_op(0, 8), ahead, back]) is None
    # 12 steps end 33 units short of the box
    assert commute(*start, ahead[:12], back[:12])
