"""Ways to restore the state of an environment that people use, compared with the exact ones."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from ...adapters.simulators import find_mujoco


class SetStateSnapshots:
    """``set_state`` of gymnasium's MuJoCo environments: positions and velocities of the joints.

    Raises LookupError for an environment without MuJoCo.
    """

    name = "set_state"

    def __init__(self, env: Any):
        self.env, self._simulator = env, find_mujoco(env)
        if self._simulator is None:
            raise LookupError("no MuJoCo simulation")

    def reset(self, seed: int) -> tuple[Any, dict]:
        return self.env.reset(seed=seed)

    def step(self, action: np.ndarray) -> tuple:
        return self.env.step(action)

    def snapshot(self) -> Any:
        assert self._simulator is not None
        data = self._simulator.data
        return data.qpos.copy(), data.qvel.copy(), float(data.time)

    def restore(self, snapshot: Any) -> None:
        import mujoco

        assert self._simulator is not None
        model, data = self._simulator
        data.qpos[:], data.qvel[:], data.time = snapshot
        mujoco.mj_forward(model, data)

    def close(self) -> None:
        pass


class DeepcopySnapshots:
    """``copy.deepcopy`` of the environment."""

    name = "deepcopy"

    def __init__(self, env: Any):
        self.env = env

    def reset(self, seed: int) -> tuple[Any, dict]:
        return self.env.reset(seed=seed)

    def step(self, action: np.ndarray) -> tuple:
        return self.env.step(action)

    def snapshot(self) -> Any:
        return copy.deepcopy(self.env)

    def restore(self, snapshot: Any) -> None:
        self.env = copy.deepcopy(snapshot)

    def close(self) -> None:
        pass
