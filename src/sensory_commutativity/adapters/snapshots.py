"""Exact snapshots of any Gymnasium environment.

An environment whose state is restored exactly continues, with the same actions, to bit-identical
observations. There are three ways, and which of them is exact depends on the environment, so that
each is tried out (:func:`choose_snapshots`) before it is used:

``native``
    A copy of the simulator's whole state (MuJoCo's ``mjData`` and the fields of the model that
    resets write) and of the plain Python attributes and random generators of the environment and of
    all its wrappers.
``replay``
    A reset with the same seed, and the same actions since then.
``fork``
    The environment lives in a process of its own; a snapshot is a copy of that process that waits.
    Exact for every simulator, on systems that can fork.

>>> import gymnasium
>>> env = ExactSnapshot(gymnasium.make("Pendulum-v1"))
>>> _ = env.reset(seed=1)
>>> start = env.snapshot()
>>> first = env.step(env.action_space.high)[0]
>>> env.restore(start)
>>> bool((env.step(env.action_space.high)[0] == first).all())
True
"""

from __future__ import annotations

import os
import socket
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, Protocol

import gymnasium
import numpy as np

from ..errors import ArgumentError, WorldError
from ..seeding import generator
from .attributes import record
from .forking import fork_from, receive, send, serve
from .simulators import find_bullet, find_mujoco

TRIES = 20
"""Tries of the self-test. Chosen: BipedalWalker, whose replay is exact in 84 % of tries, passes 5
tries in 42 % of all cases, and 20 in 3 %."""
PREFIX, LENGTH = 20, 10
"""Actions before the snapshot, and after it, in a try. Chosen."""
MODEL_FIELDS = (
    "body_pos", "body_quat", "site_pos", "site_quat", "geom_pos", "geom_quat", "geom_rgba",
    "eq_data", "qpos0",
)  # fmt: skip
"""Fields of MuJoCo's model that resets of gymnasium-robotics write."""


class Snapshots(Protocol):
    """A way to restore the state of an environment.

    Attributes
    ----------
    name : str
    """

    name: str

    def reset(self, seed: int) -> tuple[Any, dict]:
        """Reset the environment; returns the observation and the info."""

    def step(self, action: np.ndarray) -> tuple:
        """As the environment's own."""

    def snapshot(self) -> Any:
        """Return the present situation."""

    def restore(self, snapshot: Any) -> None:
        """Return to it. Snapshots can be restored any number of times, in any order."""

    def close(self) -> None:
        """Release what the snapshots hold."""


class NativeSnapshots:
    """Copies of the simulator's state and of Python attributes; raises LookupError for an
    environment whose simulator is not known to be copied whole."""

    name = "native"

    def __init__(self, env: gymnasium.Env):
        self.env = env
        self._simulator = find_mujoco(env)
        if self._simulator is None and (find_bullet(env) is not None or _uses_box2d(env)):
            raise LookupError("the simulator offers no copy of its whole state")

    def reset(self, seed: int) -> tuple[Any, dict]:
        return self.env.reset(seed=seed)

    def step(self, action: np.ndarray) -> tuple:
        return self.env.step(action)

    def snapshot(self) -> Any:
        attributes = record(self.env, {}, 0)
        if self._simulator is None:
            return attributes, None, None
        import mujoco

        model, data = self._simulator
        state = mujoco.MjData(model)
        mujoco.mj_copyData(state, model, data)
        return attributes, state, {name: getattr(model, name).copy() for name in MODEL_FIELDS}

    def restore(self, snapshot: Any) -> None:
        attributes, state, fields = snapshot
        attributes()
        if self._simulator is None:
            return
        import mujoco

        model, data = self._simulator
        for name, content in fields.items():
            getattr(model, name)[...] = content
        mujoco.mj_copyData(data, model, state)

    def close(self) -> None:
        pass


class ReplaySnapshots:
    """A reset with the same seed, and the same actions since then."""

    name = "replay"

    def __init__(self, env: gymnasium.Env):
        self.env = env
        self._seed: int | None = None
        self._actions: list[np.ndarray] = []

    def reset(self, seed: int) -> tuple[Any, dict]:
        self._seed, self._actions = seed, []
        return self.env.reset(seed=seed)

    def step(self, action: np.ndarray) -> tuple:
        self._actions.append(np.array(action))
        return self.env.step(action)

    def snapshot(self) -> Any:
        if self._seed is None:
            raise WorldError("replay needs an episode that began with reset(seed=...)")
        return self._seed, tuple(self._actions)

    def restore(self, snapshot: Any) -> None:
        seed, actions = snapshot
        self.reset(seed)
        for action in actions:
            self.step(action)

    def close(self) -> None:
        pass


class ForkSnapshots:
    """The environment in a process of its own, of which snapshots are copies that wait.

    The environment in this process stays as it was when the object was made.

    Raises
    ------
    LookupError
        On a system that cannot fork.
    """

    name = "fork"

    def __init__(self, env: Any):
        if not hasattr(os, "fork") or not hasattr(socket, "send_fds"):
            raise LookupError("this system cannot fork processes")
        self.env = env
        self._active, theirs = socket.socketpair()
        self._holders: list[weakref.ref[_Holder]] = []
        self._process = os.fork()
        if self._process == 0:
            self._active.close()
            serve(env, theirs)
        theirs.close()

    def call(self, method: str, *arguments: Any, **keywords: Any) -> Any:
        """Call a method of the environment in its process."""
        send(self._active, (method, arguments, keywords))
        return receive(self._active)

    def reset(self, seed: int) -> tuple[Any, dict]:
        return self.call("reset", seed=seed)

    def step(self, action: np.ndarray) -> tuple:
        return self.call("step", action)

    def snapshot(self) -> Any:
        """The process that is active now waits from here on; a copy of it goes on."""
        holder = _Holder(self._active)
        self._holders.append(weakref.ref(holder))
        self._active = fork_from(holder.channel)
        return holder

    def restore(self, snapshot: Any) -> None:
        """A new copy of the process that waits takes the place of the active one."""
        if snapshot.channel.fileno() < 0:
            raise WorldError("the snapshot belongs to an environment that was closed")
        self._active.close()  # its process ends when nobody is at the other end
        self._active = fork_from(snapshot.channel)

    def close(self) -> None:
        self._active.close()
        for reference in self._holders:
            holder = reference()
            if holder is not None:
                holder.channel.close()
        self._holders.clear()
        if self._process:
            with suppress(ChildProcessError):
                os.waitpid(self._process, 0)
            self._process = 0


class _Holder:
    """A process that waits; it ends when the last reference to it is gone."""

    def __init__(self, channel: socket.socket):
        self.channel = channel

    def __del__(self) -> None:
        self.channel.close()


WAYS: dict[str, Callable[[Any], Any]] = {
    "native": NativeSnapshots,
    "replay": ReplaySnapshots,
    "fork": ForkSnapshots,
}
"""Name -> class, the cheapest first."""


class Exactness(NamedTuple):
    """How often a way was exact; an error in words if it could not be tried."""

    way: str
    tries: int
    exact: int
    error: str = ""

    def __str__(self) -> str:
        return f"{self.way} {self.error or f'{self.exact} of {self.tries}'}"


def measure_exactness(
    env: gymnasium.Env,
    way: str | Callable[[Any], Snapshots],
    tries: int = TRIES,
    seed: int = 0,
) -> Exactness:
    """Count how often an environment continues exactly as if it had not been restored.

    In every try the environment is reset, plays 20 random actions and is kept; a sequence is played
    straight on, and again after a restore, after another sequence and a restore, and at last after
    an episode with another seed. All observations have to be bit-identical.

    Parameters
    ----------
    env : gymnasium.Env
    way : {"native", "replay", "fork"} or callable
        A key of WAYS, or a class with the methods of :class:`Snapshots`.
    tries : int
    seed : int
        Determines the actions and the seeds of the episodes.
    """
    make = WAYS[way] if isinstance(way, str) else way
    name = way if isinstance(way, str) else getattr(way, "name", "own")
    exact = 0
    try:
        snapshots = make(env)
        try:
            for i in range(tries):
                exact += _is_exact(snapshots, env.action_space, generator(seed, "exact", i))
        finally:
            snapshots.close()
    except Exception as error:  # what simulators raise when they are copied is of all kinds
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return Exactness(name, tries, exact, reason[:100])
    return Exactness(name, tries, exact)


def choose_snapshots(
    env: gymnasium.Env, way: str = "auto", tries: int = TRIES, seed: int = 0
) -> tuple[Snapshots, list[Exactness]]:
    """Choose the first way that is exact in every try: native, then replay, then fork.

    Parameters
    ----------
    env : gymnasium.Env
        Is reset. With ``fork``, it goes on in another process.
    way : {"auto", "native", "replay", "fork"}
    tries : int
    seed : int

    Returns
    -------
    snapshots : Snapshots
    tried : list of Exactness
        Every way that was tried, the chosen one last.

    Raises
    ------
    WorldError
        If no way is exact; with how often each was.
    """
    if way != "auto" and way not in WAYS:
        raise ArgumentError(f"way: expected auto or one of {', '.join(WAYS)}; got {way!r}")
    tried = []
    for name in WAYS if way == "auto" else (way,):
        tried.append(measure_exactness(env, name, tries, seed))
        if tried[-1].exact == tries:
            return WAYS[name](env), tried
    counts = "; ".join(map(str, tried))
    raise WorldError(
        f"the state cannot be restored exactly ({counts}); look for a wrapper that keeps "
        "something over a reset, or for noise without a seed"
    )


class ExactSnapshot(gymnasium.Wrapper):
    """A Gymnasium wrapper with exact ``snapshot()`` and ``restore(snapshot)``.

    Parameters
    ----------
    env : gymnasium.Env
    way : {"auto", "native", "replay", "fork"}
    tries : int
        Tries of the self-test that chooses the way.

    Attributes
    ----------
    way : str
        The way that was chosen.
    tried : list of Exactness
    """

    def __init__(self, env: gymnasium.Env, way: str = "auto", tries: int = TRIES):
        super().__init__(env)
        self._snapshots, self.tried = choose_snapshots(env, way, tries)
        self.way = self._snapshots.name
        self._seeds = np.random.default_rng()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset; without a seed, the next one is drawn from a generator that the last one seeded.

        With ``fork`` the environment in this process does not move: use what this wrapper returns,
        and :meth:`render`.
        """
        if options:
            raise ArgumentError("options: an exact reset takes a seed alone; leave them out")
        if seed is not None:
            self._seeds = np.random.default_rng(seed)
            return self._snapshots.reset(seed)
        return self._snapshots.reset(int(self._seeds.integers(2**31)))

    def render(self) -> Any:
        """As the environment's own, where it is now."""
        if isinstance(self._snapshots, ForkSnapshots):
            return self._snapshots.call("render")
        return super().render()

    def step(self, action: Any) -> tuple:
        return self._snapshots.step(action)

    def snapshot(self) -> Any:
        """Return the present situation, for :meth:`restore`."""
        return self._snapshots.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Return to a situation, as often as needed."""
        self._snapshots.restore(snapshot)

    @contextmanager
    def restored(self) -> Iterator[ExactSnapshot]:
        """Return to the present situation at the end of a ``with`` block."""
        start = self.snapshot()
        try:
            yield self
        finally:
            self.restore(start)

    def close(self) -> None:
        self._snapshots.close()
        super().close()


def flatten_observation(observation: Any) -> np.ndarray:
    """One new float64 vector of an observation: an array, or a dict of them by sorted keys."""
    if isinstance(observation, dict):
        parts = [flatten_observation(observation[key]) for key in sorted(observation)]
        return np.concatenate(parts) if parts else np.zeros(0)
    if isinstance(observation, tuple):
        return np.concatenate([flatten_observation(part) for part in observation])
    return np.array(observation, np.float64).ravel()  # some environments return one array again


# ---- the self-test -------------------------------------------------------------------------------


def _is_exact(snapshots: Snapshots, space: Any, rng: np.random.Generator) -> bool:
    def draw(n: int) -> Any:
        if not isinstance(space, gymnasium.spaces.Box):
            space.seed(int(rng.integers(2**31)))
            return [space.sample() for _ in range(n)]
        low, high = np.maximum(space.low, -1e3), np.minimum(space.high, 1e3)
        return rng.uniform(low, high, (n, *space.shape)).astype(space.dtype)

    def play(actions: Any) -> list[bytes]:
        return [flatten_observation(snapshots.step(a)[0]).tobytes() for a in actions]

    first_seed, other_seed = (int(s) for s in rng.integers(2**31, size=2))
    snapshots.reset(first_seed)
    play(draw(PREFIX))
    sequence, other = draw(LENGTH), draw(LENGTH)
    start = snapshots.snapshot()
    straight = play(sequence)
    endings = []
    for between in (None, other, "episode"):
        if between is other:
            snapshots.restore(start)
            play(other)
        elif between is not None:
            snapshots.reset(other_seed)
            play(other)
        snapshots.restore(start)
        endings.append(play(sequence))
    return all(ending == straight for ending in endings)


def _uses_box2d(env: Any) -> bool:
    return type(getattr(env.unwrapped, "world", None)).__module__.startswith("Box2D")
