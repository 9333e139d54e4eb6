"""The segmented LSTM pass, against sb3-contrib's loop over steps, for any episode starts."""

from __future__ import annotations

import numpy as np
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy

from sensory_commutativity.navigation.recurrent import SegmentedLstmPolicy

INPUTS, HIDDEN = 3, 4


def run_lstm(starts: np.ndarray, seed: int):
    """Outputs, states and gradients of ours and of sb3-contrib's pass, in double precision.

    `starts` is bool (sequences, steps).
    """
    torch.manual_seed(seed)
    n, steps = starts.shape
    lstm = torch.nn.LSTM(INPUTS, HIDDEN).double()
    weights = torch.randn(n * steps, HIDDEN).double()
    features = torch.randn(n * steps, INPUTS).double()
    states = tuple(torch.randn(1, n, HIDDEN).double() for _ in range(2))
    begins = torch.tensor(starts.reshape(-1), dtype=torch.float64)
    results = []
    for policy in (SegmentedLstmPolicy, RecurrentActorCriticPolicy):
        x, h, c = (part.clone().requires_grad_() for part in (features, *states))
        output, after = policy._process_sequence(x, (h, c), begins, lstm)
        loss = (output * weights).sum()
        gradients = torch.autograd.grad(loss, [x, h, c, *lstm.parameters()])
        results.append((output, after, gradients))
    return results


def assert_equal(starts: np.ndarray, seed: int = 0) -> None:
    ours, theirs = run_lstm(starts, seed)
    assert ours[0].shape == theirs[0].shape
    assert torch.allclose(ours[0], theirs[0], rtol=0, atol=1e-12)
    for a, b in zip(ours[2], theirs[2], strict=True):
        assert torch.allclose(a, b, rtol=0, atol=1e-11)
    if starts.shape[1] == 1:
        for a, b in zip(ours[1], theirs[1], strict=True):
            assert torch.allclose(a, b, rtol=0, atol=1e-12)


@st.composite
def episode_starts(draw) -> np.ndarray:
    n, steps = draw(st.integers(1, 5)), draw(st.integers(1, 17))
    flat = draw(st.lists(st.booleans(), min_size=n * steps, max_size=n * steps))
    return np.array(flat).reshape(n, steps)


@given(episode_starts(), st.integers(0, 100))
def test_any_starts(starts, seed):
    assert_equal(starts, seed)


@given(st.integers(1, 5), st.integers(1, 40), st.data())
def test_few_starts(n, steps, data):
    """Long segments, and length groups without any segment."""
    starts = np.zeros((n, steps), bool)
    for sequence in range(n):
        for step in data.draw(st.lists(st.integers(0, steps - 1), max_size=2)):
            starts[sequence, step] = True
    assert_equal(starts)


@settings(max_examples=20)
@given(st.integers(1, 4), st.integers(1, 20))
def test_starts_at_all_steps_at_none_and_at_the_first_and_last_only(n, steps):
    everywhere, nowhere = np.ones((n, steps), bool), np.zeros((n, steps), bool)
    first = nowhere.copy()
    first[:, 0] = True
    last = nowhere.copy()
    last[:, -1] = True
    for starts in (everywhere, nowhere, first, last):
        assert_equal(starts)


@given(episode_starts())
def test_sequences_are_independent(starts):
    """The first sequence gives the same outputs alone."""
    torch.manual_seed(0)
    n, steps = starts.shape
    lstm = torch.nn.LSTM(INPUTS, HIDDEN).double()
    features = torch.randn(n * steps, INPUTS).double()
    states = tuple(torch.randn(1, n, HIDDEN).double() for _ in range(2))
    begins = torch.tensor(starts.reshape(-1), dtype=torch.float64)
    together, _ = SegmentedLstmPolicy._process_sequence(features, states, begins, lstm)
    first = tuple(state[:, :1] for state in states)
    alone, _ = SegmentedLstmPolicy._process_sequence(features[:steps], first, begins[:steps], lstm)
    assert torch.allclose(together[:steps], alone, rtol=0, atol=1e-12)
