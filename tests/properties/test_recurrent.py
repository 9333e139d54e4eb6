"""The LSTM without padding, against sb3-contrib's loop over the steps, for any rooms, steps and episode starts."""

from __future__ import annotations

import numpy as np
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy

from sensory_commutativity.navigation.recurrent import RoomPolicy

INPUTS, HIDDEN = 3, 4


def both(starts: np.ndarray, seed: int):
    """Outputs, states and gradients of ours and of sb3-contrib's, in double precision; `starts` is bool (rooms, steps)."""
    torch.manual_seed(seed)
    n, steps = starts.shape
    lstm = torch.nn.LSTM(INPUTS, HIDDEN).double()
    weights, features = (
        torch.randn(n * steps, HIDDEN).double(),
        torch.randn(n * steps, INPUTS).double(),
    )
    states = tuple(torch.randn(1, n, HIDDEN).double() for _ in range(2))
    found = []
    for policy in (RoomPolicy, RecurrentActorCriticPolicy):
        x, h, c = (part.clone().requires_grad_() for part in (features, *states))
        output, after = policy._process_sequence(
            x, (h, c), torch.tensor(starts.reshape(-1), dtype=torch.float64), lstm
        )
        found.append(
            (
                output,
                after,
                torch.autograd.grad((output * weights).sum(), [x, h, c, *lstm.parameters()]),
            )
        )
    return found


def agree(starts: np.ndarray, seed: int = 0) -> None:
    (output, after, gradients), (expected, expected_after, expected_gradients) = both(starts, seed)
    assert output.shape == expected.shape
    assert torch.allclose(output, expected, rtol=0, atol=1e-12)
    for a, b in zip(gradients, expected_gradients, strict=True):
        assert torch.allclose(a, b, rtol=0, atol=1e-11)
    if starts.shape[1] == 1:
        for a, b in zip(after, expected_after, strict=True):
            assert torch.allclose(a, b, rtol=0, atol=1e-12)


@st.composite
def rollouts(draw) -> np.ndarray:
    n, steps = draw(st.integers(1, 5)), draw(st.integers(1, 17))
    return np.array(draw(st.lists(st.booleans(), min_size=n * steps, max_size=n * steps))).reshape(
        n, steps
    )


@given(rollouts(), st.integers(0, 100))
def test_any_starts(starts, seed):
    agree(starts, seed)


@given(st.integers(1, 5), st.integers(1, 40), st.data())
def test_few_starts(n, steps, data):
    """Long drawables, and groups of them that are empty."""
    starts = np.zeros((n, steps), bool)
    for room in range(n):
        for step in data.draw(st.lists(st.integers(0, steps - 1), max_size=2)):
            starts[room, step] = True
    agree(starts)


@settings(max_examples=20)
@given(st.integers(1, 4), st.integers(1, 20))
def test_starts_everywhere_nowhere_and_at_the_first_step_only(n, steps):
    everywhere, nowhere = np.ones((n, steps), bool), np.zeros((n, steps), bool)
    first = nowhere.copy()
    first[:, 0] = True
    last = nowhere.copy()
    last[:, -1] = True
    for starts in (everywhere, nowhere, first, last):
        agree(starts)


@given(rollouts())
def test_rooms_do_not_see_each_other(starts):
    """The first room gives what it would give alone."""
    torch.manual_seed(0)
    n, steps = starts.shape
    lstm = torch.nn.LSTM(INPUTS, HIDDEN).double()
    features, states = (
        torch.randn(n * steps, INPUTS).double(),
        tuple(torch.randn(1, n, HIDDEN).double() for _ in range(2)),
    )
    begins = torch.tensor(starts.reshape(-1), dtype=torch.float64)
    together, _ = RoomPolicy._process_sequence(features, states, begins, lstm)
    alone, _ = RoomPolicy._process_sequence(
        features[:steps], tuple(state[:, :1] for state in states), begins[:steps], lstm
    )
    assert torch.allclose(together[:steps], alone, rtol=0, atol=1e-12)
