"""Action spaces made from measured SCPs (paper, section IV-B), as wrappers for any Gymnasium environment.

A degree of freedom that is seldom commutative changes the world a lot: `truncated` keeps the half with the lowest SCP, `adapted` scales every
interval by l(SCP). Two controls that the paper lacks tell whether it is the SCP that helps or any reduction: `random-half` and `inverse`.

>>> scp = {"drive": 0.6, "turn": 0.7, "lift": 0.9, "blink": 1.0}
>>> action_scales("truncated", scp)
{'drive': 1.0, 'turn': 1.0, 'lift': 0.0, 'blink': 0.0}
>>> {dof: round(scale, 2) for dof, scale in action_scales("adapted", scp).items()}
{'drive': 1.0, 'turn': 0.75, 'lift': 0.25, 'blink': 0.0}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import gymnasium as gym
import numpy as np
import pandas as pd
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from ..errors import UserError

Scp = Mapping[str, float]
"""Degree of freedom -> SCP, in the order of the environment's actions."""


class ScpError(UserError):
    """A SCP table does not have what an action space needs."""


def _keep(scp: Scp, kept: Sequence[str]) -> dict[str, float]:
    return {dof: float(dof in kept) for dof in scp}


def _by_scp(scp: Scp) -> list[str]:
    """Degrees of freedom from the lowest to the highest SCP; equal ones in the order of the actions."""
    return sorted(scp, key=lambda dof: scp[dof])


def full(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Everything: the paper's baseline."""
    return _keep(scp, list(scp))


def truncated(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """The half with the lowest SCP (paper: SCP-truncated); the larger half where their number is odd."""
    return _keep(scp, _by_scp(scp)[: (len(scp) + 1) // 2])


def adapted(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """l(SCP), linear: the lowest SCP to 1, the highest to 0 (paper: SCP-adapted); all 1 where all are equal."""
    low, high = min(scp.values()), max(scp.values())
    return {dof: (high - value) / (high - low) if high > low else 1.0 for dof, value in scp.items()}


def random_half(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Control: a half drawn at random."""
    if rng is None:
        raise ValueError("random-half draws its half: give it a generator")
    dofs = list(scp)
    return _keep(scp, [dofs[i] for i in rng.choice(len(dofs), (len(dofs) + 1) // 2, replace=False)])


def inverse(scp: Scp, rng: np.random.Generator | None = None) -> dict[str, float]:
    """Control: the half with the highest SCP."""
    return _keep(scp, _by_scp(scp)[len(scp) // 2 :])


ACTION_SPACES: dict[str, Callable[[Scp, np.random.Generator | None], dict[str, float]]] = {
    "full": full,
    "truncated": truncated,
    "adapted": adapted,
    "random-half": random_half,
    "inverse": inverse,
}


def action_scales(
    action_space: str, scp: Scp, rng: np.random.Generator | None = None
) -> dict[str, float]:
    """How far each degree of freedom may go: degree of freedom -> factor in [0, 1] of its interval; 0 fixes it.

    Parameters
    ----------
    action_space : str
        A key of ACTION_SPACES.
    scp : mapping
        Degree of freedom -> SCP in [0, 1].
    rng : Generator
        For `random-half`, which draws from it; the others ignore it.
    """
    if action_space not in ACTION_SPACES:
        raise ValueError(
            f"there is no action space {action_space!r}; choose one of {', '.join(ACTION_SPACES)}"
        )
    return ACTION_SPACES[action_space](scp, rng)


def scp_of(
    table: pd.DataFrame,
    dofs: Sequence[str],
    world: str,
    agent: str,
    length: int,
    threshold: float = 0.0,
) -> dict[str, float]:
    """The SCPs that a table like flatland_scp holds of an agent in a world, in the order of `dofs`. Raises ScpError where one is missing or twice."""
    chosen = (
        (table["world"] == world)
        & (table["agent"] == agent)
        & (table["length"] == length)
        & (table["threshold"] == threshold)
    )
    rows = table[chosen]
    where = f"the SCP table, {agent!r} in {world!r}, length {length}, threshold {threshold:g}"
    missing = [dof for dof in dofs if dof not in set(rows["dof"])]
    if missing:
        raise ScpError(
            f"{where}: no row for {', '.join(missing)}; run the SC-experiments of every degree of freedom"
        )
    if rows["dof"].duplicated().any():
        raise ScpError(
            f"{where}: more than one row for {', '.join(rows['dof'][rows['dof'].duplicated()])}; make the table anew"
        )
    found = rows.set_index("dof")["scp"]
    wrong = [dof for dof in dofs if not 0 <= found[dof] <= 1]
    if wrong:
        raise ScpError(
            f"{where}: the SCP of {', '.join(wrong)} is no probability; make the table anew"
        )
    return {dof: float(found[dof]) for dof in dofs}


class _Scaling:
    """What both wrappers share: from the few scaled actions of a learner to the whole action of the environment."""

    def __init__(self, scales: Sequence[float], whole: spaces.Box):
        if not isinstance(whole, spaces.Box) or not np.issubdtype(whole.dtype, np.floating):
            raise ValueError(
                f"the environment's actions must be a Box of floating-point numbers in [-1, 1], not {whole}"
            )
        self.scales = np.asarray(scales, np.float64)
        if self.scales.shape != whole.shape:
            raise ValueError(
                f"an action of this environment has the shape {whole.shape}, but there are {self.scales.shape} scales"
            )
        if not ((self.scales >= 0) & (self.scales <= 1)).all():
            raise ValueError(f"scales must lie in [0, 1], got {self.scales.tolist()}")
        if not self.scales.any():
            raise ValueError("all scales are 0: nothing is left to act with")
        if not (np.allclose(whole.low, -1) and np.allclose(whole.high, 1)):
            raise ValueError(
                f"the environment's actions must lie in [-1, 1], not in [{whole.low.min():g}, {whole.high.max():g}]; rescale them first"
            )
        self.free = np.flatnonzero(self.scales)
        self.space = spaces.Box(-1.0, 1.0, (len(self.free),), whole.dtype)

    def whole(self, action: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        action = np.asarray(action)
        if action.shape != shape:
            raise ValueError(
                f"an action of this action space has the shape {shape}, got {action.shape}"
            )
        whole = np.zeros((*shape[:-1], len(self.scales)), self.space.dtype)
        whole[..., self.free] = np.clip(action, -1, 1) * self.scales[self.free]
        return whole


class ScaledAction(gym.ActionWrapper):
    """An environment whose action intervals are scaled; degrees of freedom with scale 0 are fixed and leave the action space.

    Parameters
    ----------
    env : gymnasium.Env
        Its actions are a Box of [-1, 1], one element per degree of freedom.
    scales : float (n_dofs,), each in [0, 1]
        What :func:`action_scales` gives, in the order of the actions.
    """

    def __init__(self, env: gym.Env, scales: Sequence[float]):
        super().__init__(env)
        self._scaling = _Scaling(scales, env.action_space)
        self.action_space = self._scaling.space

    def action(self, action: np.ndarray) -> np.ndarray:
        return self._scaling.whole(action, self.action_space.shape)


class ScaledActions(gym.vector.VectorActionWrapper):
    """:class:`ScaledAction` for a vector environment."""

    def __init__(self, env: gym.vector.VectorEnv, scales: Sequence[float]):
        super().__init__(env)
        self._scaling = _Scaling(scales, env.single_action_space)
        self.single_action_space = self._scaling.space
        self.action_space = batch_space(self._scaling.space, env.num_envs)

    def actions(self, actions: np.ndarray) -> np.ndarray:
        return self._scaling.whole(actions, self.action_space.shape)
