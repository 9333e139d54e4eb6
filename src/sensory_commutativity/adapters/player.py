"""Playing sequences in a Gymnasium environment until it is still, and what happened meanwhile."""

from __future__ import annotations

from typing import Any, NamedTuple

import gymnasium
import numpy as np

from ..errors import WorldError
from .control import DirectControl
from .simulators import ContactReader, MotionReader
from .snapshots import ForkSnapshots, Snapshots, flatten_observation

NOTHING = np.zeros(0)
"""In place of commands where none is given."""
QUIET_STEPS = 3
"""Steps in a row in which nothing moves that is sensed: then the environment is still. Chosen."""


class Played(NamedTuple):
    """How a sequence went.

    Attributes
    ----------
    observation : float64 (size,)
        The last one, flattened.
    touched : frozenset
        Pairs of bodies that touched at the end of any step.
    positions : float64
        Where free objects are, metres; empty where the simulator does not tell.
    terminated : bool
        Whether the episode terminated on the way; it was continued.
    rest_steps : int
        Steps without a command at the end.
    still : bool
        Whether nothing moved at the end.
    visited : float64 (steps, size), or None
        All observations, if asked for.
    """

    observation: np.ndarray
    touched: frozenset
    positions: np.ndarray
    terminated: bool
    rest_steps: int
    still: bool
    visited: np.ndarray | None = None


class Player:
    """Plays in one environment; with :class:`.ForkSnapshots` it lives in another process.

    Parameters
    ----------
    env : gymnasium.Env
    control : DirectControl
    """

    def __init__(self, env: gymnasium.Env, control: DirectControl):
        self.env, self.control = env, control
        self.contacts, self.motion = ContactReader(env), MotionReader(env)
        self.snapshots: Snapshots | None = None  # unless another process keeps them
        self._observation = np.zeros(0)

    def reset(self, seed: int) -> np.ndarray:
        """Start an episode; returns the flattened observation."""
        if self.snapshots is None:
            observation = self.env.reset(seed=seed)[0]
        else:
            observation = self.snapshots.reset(seed)[0]
        self.control.begin()
        self._observation = flatten_observation(observation)
        return self._observation

    def play(
        self,
        actions: np.ndarray,
        most_rest: int = 0,
        tolerance: np.ndarray | None = None,
        keep: bool = False,
    ) -> Played:
        """Play actions, then command nothing until nothing moves, for `most_rest` steps at most.

        Parameters
        ----------
        actions : float (steps, n), in [-1, 1]
        most_rest : int
        tolerance : float (size,), optional
            How far each number may move from one step to the next in an environment that is still.
        keep : bool
            Whether to return all observations.
        """
        touched: set[frozenset] = set()
        visited = []
        commands = self.control.commands(actions) if len(actions) else NOTHING
        pause = self.control.commands(np.zeros((1, self.control.n)))[0] if most_rest else NOTHING
        terminated, quiet, steps, n, fastest = False, 0, 0, len(actions), 0
        before = self._observation
        step = self.env.step if self.snapshots is None else self.snapshots.step
        while steps < n + most_rest and quiet < QUIET_STEPS:
            # A pause is copied, since an environment may change the array that it is given.
            raw, _, ended, truncated, _ = step(commands[steps] if steps < n else pause.copy())
            if truncated and not ended:
                raise WorldError(
                    "the environment truncates its episodes although its TimeLimit was lifted; "
                    "make it without its own limit of steps"
                )
            steps += 1
            now = flatten_observation(raw)
            if steps > n and tolerance is not None:
                # A sensor that moved mostly goes on moving: the others need not be looked at then.
                if abs(now[fastest] - before[fastest]) <= tolerance[fastest]:
                    moves = np.abs(now - before) > tolerance
                    fastest = int(moves.argmax())
                    quiet = 0 if moves[fastest] else quiet + 1
                else:
                    quiet = 0
            terminated = terminated or bool(ended)
            if self.contacts.known:
                touched.add(self.contacts.pairs())
            if keep:
                visited.append(now)
            before = now
        self._observation = before
        return Played(
            before, frozenset().union(*touched), self.motion.positions(), terminated,
            max(steps - n, 0), quiet >= QUIET_STEPS,
            np.reshape(visited, (-1, before.size)) if keep else None,
        )  # fmt: skip

    def room(self) -> tuple[np.ndarray, np.ndarray]:
        """As :meth:`.DirectControl.room`."""
        return self.control.room()

    def reseed(self, seed: int) -> None:
        """Give the environment's random generator another state, to see whether steps are noisy."""
        inner: Any = self.env.unwrapped
        inner._np_random = np.random.default_rng(seed)
        task: Any = getattr(getattr(inner, "_env", None), "task", None)  # dm_control in shimmy
        if isinstance(getattr(task, "random", None), np.random.RandomState):
            task.random.seed(seed)

    def render(self, side: int) -> np.ndarray:
        """An image of the environment, uint8 (side, side, 3)."""
        from PIL import Image

        picture: Any = self.env.render()
        resized = Image.fromarray(picture).resize((side, side), Image.Resampling.BOX)
        return np.asarray(resized.convert("RGB")).copy()

    def snapshot(self) -> Any:
        """The present situation, where this process keeps the snapshots."""
        assert self.snapshots is not None
        return self.snapshots.snapshot(), self.control.state.copy(), self._observation

    def restore(self, snapshot: Any) -> None:
        assert self.snapshots is not None
        inner, state, self._observation = snapshot
        self.snapshots.restore(inner)
        self.control.state = state.copy()


class RemotePlayer:
    """A player in a process of its own, of which snapshots are copies that wait."""

    def __init__(self, player: Player):
        self._snapshots = ForkSnapshots(player)
        self.contacts, self.motion, self.control = player.contacts, player.motion, player.control

    def reset(self, seed: int) -> np.ndarray:
        return self._snapshots.call("reset", seed)

    def play(self, *arguments: Any) -> Played:
        return self._snapshots.call("play", *arguments)

    def room(self) -> tuple[np.ndarray, np.ndarray]:
        return self._snapshots.call("room")

    def reseed(self, seed: int) -> None:
        self._snapshots.call("reseed", seed)

    def render(self, side: int) -> np.ndarray:
        return self._snapshots.call("render", side)

    def snapshot(self) -> Any:
        return self._snapshots.snapshot()

    def restore(self, snapshot: Any) -> None:
        self._snapshots.restore(snapshot)

    def close(self) -> None:
        """End the process."""
        self._snapshots.close()
