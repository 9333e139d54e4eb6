"""Action spaces derived from measured SCPs (paper, section IV-B).

The wrappers apply to any Gymnasium environment whose actions are a `Box` of [-1, 1].

A degree of freedom with a low SCP rarely commutes: it interacts with the environment a lot.
`truncated` keeps the half of the degrees of freedom with the lowest SCP; `adapted` scales the
interval of each by l(SCP). Controls that are not in the paper show whether the SCP itself matters
or any reduction helps: `random-half` and `inverse`; and, for agents with a base, `base-random`,
which keeps the base and as many others at random as `truncated` keeps in all.

>>> scp = {"drive": 0.6, "turn": 0.7, "lift": 0.9, "blink": 1.0}
>>> action_scales("truncated", scp)
{'drive': 1.0, 'turn': 1.0, 'lift': 0.0, 'blink': 0.0}
>>> {dof: round(scale, 2) for dof, scale in action_scales("adapted", scp).items()}
{'drive': 1.0, 'turn': 0.75, 'lift': 0.25, 'blink': 0.0}
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Protocol, runtime_checkable

import gymnasium as gym
import numpy as np
import pandas as pd
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from ..errors import UserError

BASE = "base-"
"""What the names of the degrees of freedom begin with that move the agent as a whole."""
Scp = Mapping[str, float]
"""Degree of freedom -> SCP in [0, 1], in the order of the environment's actions."""


@runtime_checkable
class SupportsScp(Protocol):
    """What has SCPs, such as a Measurement."""

    def scp(self) -> Scp:
        """SCP of each degree of freedom."""


class ScpError(UserError):
    """A table of SCPs lacks rows that an action space needs, or holds invalid ones."""


def _keep(scp: Scp, kept: Collection[str]) -> dict[str, float]:
    return {dof: float(dof in kept) for dof in scp}


def _sort_by_scp(scp: Scp) -> list[str]:
    """Sort from the lowest to the highest SCP; ties stay in the order of the actions."""
    return sorted(scp, key=lambda dof: scp[dof])


def keep_all(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Keep all degrees of freedom (the paper's baseline)."""
    return _keep(scp, list(scp))


def keep_low_scp(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Keep the half with the lowest SCP, rounded up (paper: SCP-truncated)."""
    return _keep(scp, _sort_by_scp(scp)[: (len(scp) + 1) // 2])


def scale_by_scp(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Scale linearly: 1 for the lowest SCP, 0 for the highest (paper: SCP-adapted).

    All scales are 1 if all SCPs are equal.
    """
    low, high = min(scp.values()), max(scp.values())
    return {dof: (high - value) / (high - low) if high > low else 1.0 for dof, value in scp.items()}


def keep_random_half(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Keep a random half, rounded up (control). Raises ValueError without a generator."""
    if rng is None:
        raise ValueError("the action space random-half needs a random generator")
    dofs = list(scp)
    return _keep(scp, [dofs[i] for i in rng.choice(len(dofs), (len(dofs) + 1) // 2, replace=False)])


def keep_base_and_random(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Keep what moves the base and random others, half of all, rounded up (control).

    A half that lacks the base may be unable to solve a task in which the agent has to get
    somewhere; this control asks whether the SCP chooses more than the base.

    Raises
    ------
    ValueError
        Without a generator, or if no degree of freedom has a name that starts with BASE, or more
        than half of them have.
    """
    if rng is None:
        raise ValueError("the action space base-random needs a random generator")
    base = [dof for dof in scp if dof.startswith(BASE)]
    others = [dof for dof in scp if dof not in base]
    n = (len(scp) + 1) // 2 - len(base)
    if not base or n < 0:
        raise ValueError(
            f"the action space base-random needs degrees of freedom called {BASE}..., at most half "
            f"of all; these are {', '.join(scp)}"
        )
    return _keep(scp, [*base, *(others[i] for i in rng.choice(len(others), n, replace=False))])


def keep_high_scp(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Keep the half with the highest SCP, rounded up (control)."""
    return _keep(scp, _sort_by_scp(scp)[len(scp) // 2 :])


ACTION_SPACES: dict[str, Callable[[Scp, np.random.Generator | None], dict[str, float]]] = {
    "full": keep_all,
    "truncated": keep_low_scp,
    "adapted": scale_by_scp,
    "base-random": keep_base_and_random,
    "random-half": keep_random_half,
    "inverse": keep_high_scp,
}


def action_scales(
    action_space: str, scp: Scp, rng: np.random.Generator | None = None
) -> dict[str, float]:
    """Compute the scale of each degree of freedom in an action space.

    Parameters
    ----------
    action_space : str
        A key of ACTION_SPACES.
    scp : mapping of str to float
        Degree of freedom -> SCP in [0, 1].
    rng : Generator, optional
        Required by ``random-half`` and ``base-random``; the others ignore it.

    Returns
    -------
    dict of str to float
        Degree of freedom -> factor of its interval in [0, 1], in the order of `scp`; 0 removes it.

    Raises
    ------
    ValueError
        If the action space is unknown, or needs a generator that is not given.
    """
    if action_space not in ACTION_SPACES:
        known = ", ".join(ACTION_SPACES)
        raise ValueError(f"unknown action space {action_space!r}; choose one of {known}")
    return ACTION_SPACES[action_space](scp, rng)


def scp_from_table(
    table: pd.DataFrame,
    dofs: Sequence[str],
    world: str,
    agent: str,
    length: int,
    threshold: float = 0.0,
) -> dict[str, float]:
    """Select the SCPs of one agent in one world from a table.

    Parameters
    ----------
    table : DataFrame
        With the columns world, agent, length, threshold, dof and scp.
    dofs : sequence of str
        Degrees of freedom, in the order of the actions.
    world, agent : str
    length : int
        Length of the action sequences, steps.
    threshold : float
        Largest distance that counts as equal, in the unit of the distance.

    Returns
    -------
    dict of str to float
        Degree of freedom -> SCP, in the order of `dofs`.

    Raises
    ------
    ScpError
        If a degree of freedom has no row or several, or its SCP lies outside [0, 1].
    """
    selected = (
        (table["world"] == world)
        & (table["agent"] == agent)
        & (table["length"] == length)
        & (table["threshold"] == threshold)
    )
    rows = table[selected]
    where = f"the SCP table, {agent!r} in {world!r}, length {length}, threshold {threshold:g}"
    missing = [dof for dof in dofs if dof not in set(rows["dof"])]
    if missing:
        raise ScpError(
            f"{where}: no row for {', '.join(missing)}; "
            "run the SC-experiments of every degree of freedom"
        )
    duplicated = rows["dof"][rows["dof"].duplicated()]
    if len(duplicated):
        names = ", ".join(duplicated)
        raise ScpError(f"{where}: more than one row for {names}; compute the table again")
    scp = rows.set_index("dof")["scp"]
    invalid = [dof for dof in dofs if not 0 <= scp[dof] <= 1]
    if invalid:
        names = ", ".join(invalid)
        raise ScpError(f"{where}: the SCP of {names} is not in [0, 1]; compute the table again")
    return {dof: float(scp[dof]) for dof in dofs}


class _Scaling:
    """The mapping from reduced, scaled actions to actions of the environment.

    Attributes
    ----------
    space : Box
        Reduced action space: the degrees of freedom with a scale above 0.
    """

    def __init__(self, scales: Sequence[float], full_space: spaces.Space):
        if not isinstance(full_space, spaces.Box) or not np.issubdtype(
            full_space.dtype, np.floating
        ):
            raise ValueError(
                f"the environment's actions must be a Box of floats in [-1, 1], not {full_space}"
            )
        self.scales = np.asarray(scales, np.float64)
        if self.scales.shape != full_space.shape:
            raise ValueError(
                f"scales have the shape {self.scales.shape}, "
                f"but actions of the environment have the shape {full_space.shape}"
            )
        if not ((self.scales >= 0) & (self.scales <= 1)).all():
            raise ValueError(f"scales must lie in [0, 1], got {self.scales.tolist()}")
        if not self.scales.any():
            raise ValueError("all scales are 0: the action space would be empty")
        if not (np.allclose(full_space.low, -1) and np.allclose(full_space.high, 1)):
            raise ValueError(
                "the environment's actions must lie in [-1, 1], not in "
                f"[{full_space.low.min():g}, {full_space.high.max():g}]; rescale them first"
            )
        self.free = np.flatnonzero(self.scales)
        self.space = spaces.Box(-1.0, 1.0, (len(self.free),), full_space.dtype)

    def expand(self, actions: np.ndarray, batch_shape: tuple[int, ...] = ()) -> np.ndarray:
        """Clip and scale reduced actions (..., n_free) and insert zeros: (..., n_dofs)."""
        actions = np.asarray(actions)
        expected = (*batch_shape, len(self.free))
        if actions.shape != expected:
            raise ValueError(
                f"actions of this action space have the shape {expected}, got {actions.shape}"
            )
        full = np.zeros((*batch_shape, len(self.scales)), self.space.dtype)
        full[..., self.free] = np.clip(actions, -1, 1) * self.scales[self.free]
        return full


class ScaledAction(gym.ActionWrapper):
    """Scale the actions of an environment and remove those with scale 0.

    Actions of the wrapped environment are clipped to [-1, 1] and multiplied by their scales.
    Removed degrees of freedom receive 0.

    Parameters
    ----------
    env : gymnasium.Env
        Its actions are a `Box` of [-1, 1], one element per degree of freedom.
    scales : float (n_dofs,), each in [0, 1]
        In the order of the actions; see :func:`action_scales`.

    Raises
    ------
    ValueError
        If the actions of `env` are not such a `Box`, or the scales do not fit it.
    """

    def __init__(self, env: gym.Env, scales: Sequence[float]):
        super().__init__(env)
        self._scaling = _Scaling(scales, env.action_space)
        self.action_space = self._scaling.space

    def action(self, action: np.ndarray) -> np.ndarray:
        return self._scaling.expand(action)


def wrap_action_space(
    env: gym.Env,
    scp: Scp | SupportsScp,
    action_space: str = "truncated",
    rng: np.random.Generator | None = None,
) -> ScaledAction:
    """Wrap an environment in the action space that its SCPs make.

    Parameters
    ----------
    env : gymnasium.Env
        With bounded continuous actions; they are rescaled to [-1, 1] if need be, 0 to 0.
    scp : mapping of str to float, or Measurement
        SCP of each action, in the order of the actions.
    action_space : str
        A key of ACTION_SPACES.
    rng : Generator, optional
        Required by ``random-half``.

    Raises
    ------
    ValueError
        If the number of SCPs is not that of the actions, or the action space is unknown.
    """
    values: Scp = scp.scp() if isinstance(scp, SupportsScp) else scp
    scales = list(action_scales(action_space, values, rng).values())
    space = env.action_space
    if isinstance(space, spaces.Box) and not (
        np.allclose(space.low, -1) and np.allclose(space.high, 1)
    ):
        env = _rescale_around_zero(env, space)
    return ScaledAction(env, scales)


def _rescale_around_zero(env: gym.Env, space: spaces.Box) -> gym.Env:
    """Map [-1, 1] to the range of every action, 0 to 0 where the range holds it: a removed degree
    of freedom gets 0 then, not the middle of its range."""
    low, high = space.low.astype(np.float64), space.high.astype(np.float64)
    middle = np.where((low <= 0) & (high >= 0), 0.0, (low + high) / 2)

    def rescale(action: np.ndarray) -> np.ndarray:
        span = np.where(action >= 0, high - middle, middle - low)
        return (middle + action * span).astype(space.dtype)

    unit = spaces.Box(-1.0, 1.0, space.shape, space.dtype)
    return gym.wrappers.TransformAction(env, rescale, unit)


class VectorScaledAction(gym.vector.VectorActionWrapper):
    """:class:`ScaledAction` for a vector environment."""

    def __init__(self, env: gym.vector.VectorEnv, scales: Sequence[float]):
        super().__init__(env)
        self._scaling = _Scaling(scales, env.single_action_space)
        self.single_action_space = self._scaling.space
        self.action_space = batch_space(self._scaling.space, env.num_envs)

    def actions(self, actions: np.ndarray) -> np.ndarray:
        return self._scaling.expand(actions, (self.num_envs,))
