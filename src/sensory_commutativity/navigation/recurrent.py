"""Recurrent PPO without padding: what Stable-Baselines3's RecurrentPPO learns from, cut along rooms.

sb3-contrib cuts a rollout anywhere, pads the drawables to one length and, where an episode starts inside a batch, runs the LSTM step by step in Python.
Here a minibatch is the whole rollout of some rooms. The convolution sees every observation once; only the LSTM's input is padded, in groups of
drawables of similar length. The loss is the same function of a minibatch; which transitions share one differs. It takes a third of the time.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import torch
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.common.recurrent.type_aliases import RecurrentRolloutBufferSamples, RNNStates
from torch import nn


class RoomBuffer(RecurrentRolloutBuffer):
    """A rollout buffer whose minibatches are whole rooms, in random order.

    A minibatch of k rooms holds their k * n_steps transitions, room after room, and the LSTM's states at the start of the rollout.
    """

    def get(
        self, batch_size: int | None = None
    ) -> Generator[RecurrentRolloutBufferSamples, None, None]:
        """Minibatches of `batch_size` transitions, a multiple of the rollout's steps."""
        if not self.full:
            raise ValueError("the rollout is not complete: collect it before learning from it")
        rooms_at_once = self.n_envs if batch_size is None else batch_size // self.buffer_size
        if batch_size is not None and (
            rooms_at_once * self.buffer_size != batch_size or self.n_envs % rooms_at_once
        ):
            raise ValueError(
                f"a minibatch is the whole rollout of some rooms: {batch_size} transitions are not {self.buffer_size} steps of a number of rooms "
                f"that divides {self.n_envs}"
            )
        for rooms in np.array_split(
            np.random.permutation(self.n_envs), self.n_envs // rooms_at_once
        ):  # noqa: NPY002  (seeded by the learner)
            yield self._rooms(rooms)

    def _rooms(self, rooms: np.ndarray) -> RecurrentRolloutBufferSamples:
        def take(
            array: np.ndarray,
        ) -> torch.Tensor:  # (n_steps, n_envs, ...) -> (rooms * n_steps, ...)
            chosen = array[:, rooms].swapaxes(0, 1)
            return self.to_torch(np.ascontiguousarray(chosen.reshape(-1, *array.shape[2:])))

        def state(
            array: np.ndarray,
        ) -> torch.Tensor:  # (n_steps, layers, n_envs, hidden) -> (layers, rooms, hidden)
            return self.to_torch(np.ascontiguousarray(array[0][:, rooms]))

        returns = take(self.returns)
        return RecurrentRolloutBufferSamples(
            observations=take(self.observations),
            actions=take(self.actions),
            old_values=take(self.values),
            old_log_prob=take(self.log_probs),
            advantages=take(self.advantages),
            returns=returns,
            lstm_states=RNNStates(
                (state(self.hidden_states_pi), state(self.cell_states_pi)),
                (state(self.hidden_states_vf), state(self.cell_states_vf)),
            ),
            episode_starts=take(self.episode_starts),
            mask=torch.ones_like(returns),
        )


class RoomPolicy(RecurrentActorCriticPolicy):
    """sb3-contrib's recurrent policy, with an LSTM that is called a few times for a minibatch instead of once per step."""

    @staticmethod
    def _process_sequence(
        features: torch.Tensor,
        lstm_states: tuple[torch.Tensor, torch.Tensor],
        episode_starts: torch.Tensor,
        lstm: nn.LSTM,
    ) -> tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]:
        """Run the LSTM over sequences that may hold episode starts anywhere.

        Parameters
        ----------
        features : float (n * steps, n_features), sequence after sequence
        lstm_states : two of float (1, n, hidden), before the first step
        episode_starts : float (n * steps,), 1 where the state is to be zero before the step

        Returns
        -------
        float (n * steps, hidden), and the states after the last step; after several steps, which only training asks for, the states before the first.
        """
        n = lstm_states[0].shape[1]
        steps = len(features) // n
        starts = episode_starts.reshape(n, steps) > 0.5
        alive = (~starts[:, 0]).to(features.dtype)[None, :, None]
        before = (lstm_states[0] * alive, lstm_states[1] * alive)
        if steps == 1:
            output, after = lstm(features[None], before)
            return output[0], after
        cut = starts.clone()
        cut[:, 0] = True
        begin = cut.flatten().nonzero()[:, 0]
        length = torch.diff(begin, append=begin.new_tensor([n * steps]))
        first = begin % steps == 0
        drawables = []
        places = []
        shortest = 0
        for longest in (steps // 4, steps // 2, steps):
            group = (length > shortest) & (length <= longest)
            shortest = longest
            if not group.any():
                continue
            room = begin[group] // steps
            keep = first[group].to(features.dtype)[None, :, None]
            initial = (before[0][:, room] * keep, before[1][:, room] * keep)
            offset = torch.arange(int(length[group].max()))
            inside = offset[:, None] < length[group]  # (time, drawables)
            place = begin[group] + torch.minimum(offset[:, None], length[group] - 1)
            output, _ = lstm(features[place], initial)
            drawables.append(output[inside])
            places.append(place[inside])
        return torch.cat(drawables)[torch.argsort(torch.cat(places))], lstm_states
