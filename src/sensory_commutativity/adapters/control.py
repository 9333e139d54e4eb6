"""What an action of [-1, 1] commands, so that sequences commute where nothing is touched.

Sequences of velocities commute in free space; sequences of torques, or of positions to go to, do
not. Each control is a way to turn an action into a command of the environment, chosen from what the
simulator says about its actuators (:func:`choose_control`). An action of 0 commands nothing.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from ..errors import ArgumentError
from .simulators import MujocoSimulator, find_mujoco

SPEED = 0.1
"""How far an action of 1 moves the target: rad (servo), or a share of half the range (increments).
Chosen: about what the paper's robots move in a step."""
STIFFNESS = 0.1
"""Rad (or m) of error at which a servo uses all its torque. Chosen: soft enough for the time steps
of gymnasium's models."""


ACTUATOR_FIELDS = (
    "actuator_gear", "actuator_gainprm", "actuator_biastype", "actuator_biasprm",
    "actuator_ctrllimited", "actuator_forcelimited", "actuator_forcerange",
)  # fmt: skip
"""Fields of MuJoCo's model that a servo edits."""
_ORIGINAL = "_sensory_commutativity_actuators"
"""Attribute of an environment that keeps those fields as they were."""


def restore_actuators(env: gymnasium.Env) -> None:
    """Undo what an earlier control edited, so that an environment can be used again."""
    simulator = find_mujoco(env)
    if simulator is None:
        return
    kept = vars(env.unwrapped).setdefault(
        _ORIGINAL, {name: getattr(simulator.model, name).copy() for name in ACTUATOR_FIELDS}
    )
    for name, content in kept.items():
        getattr(simulator.model, name)[...] = content


def check_action_space(space: Any, name: str) -> None:
    """Raise ArgumentError unless actions are continuous and bounded."""
    if not isinstance(space, spaces.Box):
        raise ArgumentError(
            f"env: {name} has actions in {space}; only continuous actions, a Box, can be permuted "
            "within a degree of freedom"
        )
    if not (np.isfinite(space.low).all() and np.isfinite(space.high).all()):
        raise ArgumentError(
            f"env: {name} has unbounded actions; give them bounds with "
            "gymnasium.wrappers.TransformAction(env, lambda action: action, Box(low, high))"
        )


class DirectControl:
    """Actions as the environment takes them: 0 commands 0 where the range contains it, otherwise
    the middle of the range; 1 and -1 command its ends.

    Attributes
    ----------
    name : str
    n : int
        Number of actions.
    state : float array
        What the control remembers; part of a snapshot.
    """

    name = "direct"

    def __init__(self, env: gymnasium.Env):
        space = env.action_space
        assert isinstance(space, spaces.Box) and space.shape is not None
        self._shape, self._dtype = space.shape, space.dtype
        self.low = space.low.astype(np.float64).ravel()
        self.high = space.high.astype(np.float64).ravel()
        self.n = len(self.low)
        inside = (self.low <= 0) & (self.high >= 0)
        self.middle = np.where(inside, 0.0, (self.low + self.high) / 2)
        self.state = np.zeros(0)

    def begin(self) -> None:
        """Start an episode; called after the environment's reset."""

    def commands(self, actions: np.ndarray) -> np.ndarray:
        """The environment's own actions for `actions`, float (steps, n) in [-1, 1], in their order.

        A further action of 0 repeats the last command.
        """
        return self._own(self._scale(actions))

    def room(self) -> tuple[np.ndarray, np.ndarray]:
        """Actions of 1 that lead to the lower and to the upper stop; infinite if not known."""
        return np.full(self.n, np.inf), np.full(self.n, np.inf)

    def has_inverse(self) -> np.ndarray:
        """For which actions the opposite action leads back: bool (n,)."""
        return np.zeros(self.n, bool)

    def _scale(self, actions: np.ndarray) -> np.ndarray:
        """From [-1, 1] to the environment's range, float (steps, n)."""
        span = np.where(actions >= 0, self.high - self.middle, self.middle - self.low)
        return self.middle + actions * span

    def _own(self, values: np.ndarray) -> np.ndarray:
        own = np.clip(values.astype(self._dtype), self.low, self.high).astype(self._dtype)
        return own.reshape(-1, *self._shape)


class IncrementControl(DirectControl):
    """For actions that are positions to go to: an action moves the position by SPEED of half its
    range, 0 holds it."""

    name = "increments"

    def begin(self) -> None:
        self.state = np.zeros(self.n)

    def commands(self, actions: np.ndarray) -> np.ndarray:
        states = _accumulate(self.state, SPEED * actions, -1.0, 1.0)
        self.state = states[-1]
        return super().commands(states[1:])

    def room(self) -> tuple[np.ndarray, np.ndarray]:
        return (self.state + 1) / SPEED, (1 - self.state) / SPEED

    def has_inverse(self) -> np.ndarray:
        return np.ones(self.n, bool)


class ServoControl(DirectControl):
    """For MuJoCo's motors: each becomes a position servo with the greatest torque of the motor; an
    action moves its target by SPEED, 0 holds it.

    The model is edited in place. Actuators that are no motor on one joint keep their own actions.

    Raises
    ------
    ArgumentError
        If the environment has no such motor, or actions that are no actuators.
    """

    name = "servo"

    def __init__(self, env: gymnasium.Env):
        super().__init__(env)
        simulator = find_mujoco(env)
        self.motors = np.zeros(0, int) if simulator is None else find_motors(simulator.model)
        if simulator is None or simulator.model.nu != self.n or not len(self.motors):
            raise ArgumentError("control: a servo needs MuJoCo's motors, one per action")
        wrapper = find_action_wrapper(env)
        if wrapper is not None:
            raise ArgumentError(
                f"control: a servo cannot work through {wrapper}, which changes actions; take the "
                "wrapper away, or choose control='direct'"
            )
        self._data = simulator.data
        self._edit(simulator)

    def _edit(self, simulator: MujocoSimulator) -> None:
        import mujoco

        model, w = simulator.model, self.motors
        joints = model.actuator_trnid[w, 0]
        self._address = model.jnt_qposadr[joints]
        gain = np.abs(model.actuator_gear[w, 0] * model.actuator_gainprm[w, 0])
        torque = gain * np.maximum(np.abs(self.low), np.abs(self.high))[w]
        kp = torque / STIFFNESS
        kv = 2 * np.sqrt(kp * model.dof_M0[model.jnt_dofadr[joints]])  # critically damped
        model.actuator_gear[w] = np.eye(6)[0]
        model.actuator_gainprm[w, 0] = kp
        model.actuator_biastype[w] = int(mujoco.mjtBias.mjBIAS_AFFINE)
        model.actuator_biasprm[w, :3] = np.stack([np.zeros_like(kp), -kp, -kv], 1)
        model.actuator_ctrllimited[w] = 0
        model.actuator_forcelimited[w] = 1
        model.actuator_forcerange[w] = np.stack([-torque, torque], 1)
        limited = model.jnt_limited[joints].astype(bool)[:, None]
        self._stops = np.where(limited, model.jnt_range[joints], [-np.inf, np.inf])

    def begin(self) -> None:
        self.state = self._data.qpos[self._address].copy()

    def commands(self, actions: np.ndarray) -> np.ndarray:
        steps = SPEED * actions[:, self.motors]
        states = _accumulate(self.state, steps, self._stops[:, 0], self._stops[:, 1])
        self.state = states[-1]
        if len(self.motors) == self.n:
            values = states[1:]
        else:
            values = self._scale(actions)
            values[:, self.motors] = states[1:]
        # Targets may lie beyond the range of the environment's own actions.
        return values.astype(self._dtype).reshape(-1, *self._shape)

    def room(self) -> tuple[np.ndarray, np.ndarray]:
        down, up = super().room()
        down[self.motors] = (self.state - self._stops[:, 0]) / SPEED
        up[self.motors] = (self._stops[:, 1] - self.state) / SPEED
        return np.maximum(down, 0), np.maximum(up, 0)

    def has_inverse(self) -> np.ndarray:
        known = np.zeros(self.n, bool)
        known[self.motors] = True
        return known


CONTROLS: dict[str, type[DirectControl]] = {
    "direct": DirectControl,
    "increments": IncrementControl,
    "servo": ServoControl,
}
"""Name -> class."""


def _accumulate(
    start: np.ndarray, steps: np.ndarray, low: np.ndarray | float, high: np.ndarray | float
) -> np.ndarray:
    """Positions on the way from `start` by `steps`, float (steps, n), that stay between `low` and
    `high`; with the start itself, float (steps + 1, n)."""
    reached = np.cumsum(np.concatenate([start[None], steps]), axis=0)
    if ((reached[1:] < low) | (reached[1:] > high)).any():
        for i, step in enumerate(steps):
            reached[i + 1] = np.minimum(np.maximum(reached[i] + step, low), high)
    return reached


def find_motors(model: Any) -> np.ndarray:
    """Indices of the actuators that are plain motors, each on one hinge or slide: their force is
    the command times a fixed gain."""
    import mujoco

    joints = np.clip(model.actuator_trnid[:, 0], 0, model.njnt - 1)
    single = np.isin(
        model.jnt_type[joints],
        [int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)],
    )
    return np.flatnonzero(
        (model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT))
        & single
        & (model.actuator_gaintype == int(mujoco.mjtGain.mjGAIN_FIXED))
        & (model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_NONE))
        & (model.actuator_dyntype == int(mujoco.mjtDyn.mjDYN_NONE))
    )


def find_position_actuators(model: Any) -> np.ndarray:
    """Indices of the actuators that go to a position: their force falls with the position."""
    import mujoco

    affine = model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_AFFINE)
    return np.flatnonzero(affine & (model.actuator_biasprm[:, 1] != 0))


def find_action_wrapper(env: gymnasium.Env) -> str | None:
    """Name of a wrapper that changes actions on their way to the simulator, if there is one."""
    wrapper: Any = env
    while isinstance(wrapper, gymnasium.Wrapper):
        if isinstance(wrapper, gymnasium.ActionWrapper):
            return type(wrapper).__name__
        wrapper = wrapper.env
    return None


def choose_control(env: gymnasium.Env, control: str = "auto") -> tuple[DirectControl, str]:
    """Choose how actions become commands.

    Parameters
    ----------
    env : gymnasium.Env
        Its model may be edited.
    control : {"auto", "direct", "increments", "servo"}
        ``auto``: servos for MuJoCo's motors, increments for its position actuators, direct for
        everything else.

    Returns
    -------
    control : DirectControl
    reason : str
        Why, in a few words.
    """
    restore_actuators(env)
    if control != "auto":
        if control not in CONTROLS:
            raise ArgumentError(
                f"control: expected auto or one of {', '.join(CONTROLS)}; got {control!r}"
            )
        return CONTROLS[control](env), "as asked for"
    simulator = find_mujoco(env)
    assert env.action_space.shape is not None
    if simulator is None or simulator.model.nu != int(np.prod(env.action_space.shape)):
        return DirectControl(env), "the simulator says nothing about the actions"
    model = simulator.model
    motors, positions = len(find_motors(model)), len(find_position_actuators(model))
    wrapper = find_action_wrapper(env)
    if motors and wrapper is not None:
        return DirectControl(env), f"{wrapper} changes the actions, which a servo cannot have"
    if motors:
        return ServoControl(env), f"{motors} of {model.nu} actuators are motors"
    if positions == model.nu:
        return IncrementControl(env), "all actuators go to positions"
    return DirectControl(env), "some actuators are neither motors nor go to positions"
