"""scp/sequences.py: sampling, permuting and composing action sequences."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sensory_commutativity.scp.sequences import compose, inverse, no_op, permute, sample_sequence

sequences = st.integers(0, 12).flatmap(
    lambda n: arrays(np.float64, (n, 3), elements=st.floats(-1, 1))
)


@given(st.integers(0, 2**32), st.integers(1, 60), st.integers(0, 7))
def test_samples_command_one_dof(seed, length, dof):
    sequence = sample_sequence(np.random.default_rng(seed), length, dof, 8)
    assert sequence.shape == (length, 8)
    assert sequence.dtype == np.float64
    assert (sequence[:, dof] != 0).all()
    assert (np.abs(sequence) <= 1).all()
    assert not np.delete(sequence, dof, axis=1).any()


def test_samples_are_uniform():
    values = sample_sequence(np.random.default_rng(1), 20_000, 2, 4)[:, 2]
    counts, _ = np.histogram(values, bins=10, range=(-1, 1))
    assert counts.sum() == 20_000
    assert np.abs(counts - 2000).max() < 5 * np.sqrt(2000)


def test_samples_are_determined_by_the_generator():
    first, second = (sample_sequence(np.random.default_rng(5), 10, 0, 1) for _ in range(2))
    assert np.array_equal(first, second)
    rng = np.random.default_rng(5)
    assert not np.array_equal(sample_sequence(rng, 10, 0, 1), sample_sequence(rng, 10, 0, 1))


def test_a_shorter_sample_is_a_prefix_of_a_longer_one():
    """The study of the sequence length compares like with like."""
    short, long = (sample_sequence(np.random.default_rng(5), n, 1, 3) for n in (10, 30))
    assert np.array_equal(short, long[:10])


@given(st.integers(0, 2**32), sequences)
def test_permutations_have_the_same_actions(seed, sequence):
    copy = sequence.copy()
    permuted = permute(np.random.default_rng(seed), sequence)
    assert sorted(map(tuple, permuted)) == sorted(map(tuple, sequence))
    assert not np.shares_memory(permuted, sequence)
    assert np.array_equal(sequence, copy)


def test_all_permutations_are_equally_likely():
    sequence, rng = np.arange(3.0)[:, None], np.random.default_rng(3)
    orders = [tuple(permute(rng, sequence)[:, 0]) for _ in range(6000)]
    counts = [orders.count(order) for order in set(orders)]
    assert len(counts) == 6
    assert max(abs(count - 1000) for count in counts) < 5 * np.sqrt(1000)


def test_compose_is_in_the_order_of_time():
    a, b, c = (np.full((n, 2), float(n)) for n in (1, 2, 3))
    assert compose(a, b, c)[:, 0].tolist() == [1, 2, 2, 3, 3, 3]
    assert np.array_equal(compose(a), a)


@given(sequences, sequences)
def test_inverse(a, b):
    assert np.array_equal(inverse(compose(a, b)), compose(inverse(b), inverse(a)))
    assert np.array_equal(inverse(inverse(a)), a)
    assert inverse(np.array([[1.0, 0.0], [0.5, -0.25]])).tolist() == [[-0.5, 0.25], [-1.0, 0.0]]


def test_no_op_commands_nothing():
    for length in (0, 1, 5):
        assert np.array_equal(no_op(length, 4), np.zeros((length, 4)))
