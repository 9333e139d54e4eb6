"""A Gymnasium environment as a world.

Its state is restored exactly (:mod:`.snapshots`), its actions are turned into commands that commute
in free space where the simulator allows it (:mod:`.control`), sequences can be kept from reaching a
joint's stop, and each order ends when nothing moves any more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from ..errors import ArgumentError, WorldError
from ..scp.distances import scaled_difference
from ..scp.world import Dof
from ..seeding import generator
from .control import check_action_space, choose_control, restore_actuators
from .player import Played, Player, RemotePlayer
from .registry import NO_LIMIT
from .sensors import WORLD, find_world_sensors, select_sensors
from .simulators import find_mujoco
from .snapshots import TRIES, Exactness, choose_snapshots

PREFIX, HOLD, SETTLE = 40, 10, 20
"""Random actions on the way to a start, how many steps each is held, and steps without a command
after them. Chosen: long enough to leave the pose of the reset."""
UNIT_STARTS = 20
"""Ways to starts from which the unit of each sensor is taken. Chosen."""
STILL = 1e-6
"""Share of its unit that a sensor may move in a step of a still environment. Chosen."""
ROUNDING = 1e-9
"""Share by which a sequence stays off a stop, so that rounding does not count as reaching it."""
MOST_TRIES = 200
"""Draws of a start that must satisfy a condition, before giving up. Chosen."""
NEVER = "none"
"""The state is never restored."""
PIXELS = 128
"""Height and width of images, as the paper's robots see."""


class Events(NamedTuple):
    """What happened since the last restore.

    Attributes
    ----------
    touched : frozenset
        Pairs of bodies that touched.
    positions : float64
        Where free objects are, metres; empty where the simulator does not tell.
    terminated : bool
        Whether the episode terminated.
    rest_steps : int
        Steps without a command at the end.
    still : bool
        Whether nothing moved at the end.
    """

    touched: frozenset
    positions: np.ndarray
    terminated: bool
    rest_steps: int
    still: bool


class Situation(NamedTuple):
    """A snapshot, and the room that is left to the stops of each action."""

    inner: Any
    down: np.ndarray
    up: np.ndarray


class GymnasiumWorld:
    """A :class:`~sensory_commutativity.scp.world.World` made from a Gymnasium environment.

    Parameters
    ----------
    env : gymnasium.Env
        With actions in a Box with finite bounds; for one world at a time. Its model may be edited,
        and limits of steps (TimeLimit) are lifted. An episode that terminates is continued.
    control : {"auto", "direct", "increments", "servo"}
        See :func:`.choose_control`.
    snapshots : {"auto", "native", "replay", "fork", "none"}
        See :func:`.choose_snapshots`. With ``none`` the state is never restored, as on a real
        robot: the return protocol asks for no more.
    sensors : sequence of str, optional
        Keys of a Dict observation to use; all by default. ``["world"]`` are the sensors that do not
        move when nothing is touched (:func:`.find_world_sensors`), also of other observations.
        ``["pixels"]`` is an image, 128 x 128, of an environment that was made with
        ``render_mode="rgb_array"``.
    avoid_stops : bool
        Whether sequences are scaled so that no order of them reaches a joint's stop, where the
        control knows the stops.
    prefix, hold, settle : int
        A start is reached from a reset by `prefix` random actions, each held for `hold` steps, and
        `settle` steps without a command.
    accept : callable, optional
        Takes the Events on the way to a start, and says whether to use it; e.g. to start near
        objects. Starts are drawn until one is accepted.
    approach : callable, optional
        In place of random actions on the way to a start: takes all sensors, flattened, and a
        generator, and returns the next action, float (n,).
    tries : int
        Tries of the self-test of snapshots.

    Attributes
    ----------
    dofs : tuple of Dof
    control : DirectControl
    choices : list of str
        What was chosen, and why, for people.
    exactness : list of Exactness
        The ways to put the environment back that were tried.
    unit : float64 (size,)
        Spread of each sensor on the way to starts; infinite for one that never moves.

    Raises
    ------
    ArgumentError
        If the actions are not continuous and bounded, or an argument is not valid.
    WorldError
        If its state cannot be restored exactly.
    """

    def __init__(
        self,
        env: gymnasium.Env,
        *,
        control: str = "auto",
        snapshots: str = "auto",
        sensors: Sequence[str] | None = None,
        avoid_stops: bool = True,
        prefix: int = PREFIX,
        hold: int = HOLD,
        settle: int = SETTLE,
        accept: Callable[[Events], bool] | None = None,
        approach: Callable[[np.ndarray, np.random.Generator], np.ndarray] | None = None,
        tries: int = TRIES,
    ):
        spec = getattr(env, "spec", None)
        self.name = type(env.unwrapped).__name__ if spec is None else spec.id
        check_action_space(env.action_space, self.name)
        self.env, self.avoid_stops = env, avoid_stops
        self.accept, self.approach = accept, approach
        _check_way(prefix, hold, settle)
        if isinstance(sensors, str):
            raise ArgumentError(f"sensors: expected a list, got {sensors!r}; write [{sensors!r}]")
        if list(sensors or ()) == ["pixels"] and env.render_mode != "rgb_array":
            raise ArgumentError(
                "sensors: pixels need an environment made with render_mode='rgb_array'"
            )
        self._limits = _lift_limits(env)
        self._prefix, self._hold, self._settle = prefix, hold, settle
        restore_actuators(env)
        way, self.exactness = None, list[Exactness]()
        if snapshots != NEVER:
            way, self.exactness = choose_snapshots(env, snapshots, tries)
        self.control, reason = choose_control(env, control)
        player = Player(env, self.control)
        self._local = player
        self._player: Player | RemotePlayer = player
        self._pristine: Any = None
        if way is None:
            player.reset(0)
        elif way.name == "fork":
            way.close()
            self._player = RemotePlayer(player)
        else:
            player.snapshots = way
        if way is not None:
            self._keep_pristine()
        self.choices = [
            "state never restored"
            if way is None
            else f"state restored by {way.name} (exact in {self.exactness[-1].exact} of {tries} "
            "tries)",
            f"control {self.control.name} ({reason})",
        ]
        if avoid_stops and self.control.name != "direct":
            self.choices.append("sequences do not reach stops")
        self.dofs = _name_dofs(env, self.control.n)
        self._pixels = list(sensors or ()) == ["pixels"]
        of_world = list(sensors or ()) == [WORLD]
        named = None if self._pixels or of_world else sensors
        self._sensed = select_sensors(env, named, self.name)
        self._last: Played | None = None
        self._touched: frozenset = frozenset()
        self._terminated = False
        self._tolerance: np.ndarray | None = None
        self._observation = np.zeros(0)
        self._measure_unit()
        if of_world:
            self._keep_sensors(find_world_sensors(self))
        still = int(np.isinf(self.unit).sum())
        if still and not self._pixels:
            self.choices.append(f"{still} of {len(self.unit)} sensors never moved before a start")

    # ---- the protocol World ---------------------------------------------------------------------

    def reset(self, rng: np.random.Generator) -> None:
        """Reset with a seed from `rng`, and play random actions and a pause."""
        for _ in range(MOST_TRIES):
            self._go_to_start(rng)
            if self.accept is None or self.accept(self.happened()):
                self._touched, self._terminated = frozenset(), False
                return
        raise WorldError(
            f"no start was accepted in {MOST_TRIES} draws; make the condition easier, or the "
            "prefix longer"
        )

    def snapshot(self) -> Situation:
        down, up = self._player.room()
        if self._pristine is None:
            return Situation(None, down, up)
        return Situation(self._player.snapshot(), down, up)

    def restore(self, snapshot: Situation) -> None:
        if snapshot.inner is None:
            raise WorldError(
                "snapshots='none' was asked for, so that nothing can be restored; measure with "
                "protocol='return', or choose snapshots='auto'"
            )
        self._player.restore(snapshot.inner)
        self._touched, self._terminated, self._last = frozenset(), False, None

    def step(self, action: np.ndarray) -> None:
        self.play(np.asarray(action, np.float64)[None])

    def play(self, actions: np.ndarray) -> None:
        """Play actions, float (steps, n), clipped to [-1, 1]."""
        self._note(self._player.play(np.clip(actions, -1.0, 1.0)))

    def rest(self, most: int) -> None:
        """Command nothing until nothing moves, for at most `most` steps."""
        nothing = np.zeros((0, self.control.n))
        self._note(self._player.play(nothing, most, self._tolerance))

    def observe(self) -> np.ndarray:
        """The sensors, float64 (size,), or an image, uint8 (128, 128, 3)."""
        if self._pixels:
            return self._player.render(PIXELS)
        if self._last is None:  # after a restore
            self._note(self._player.play(np.zeros((0, self.control.n))))
        return self._observation[self._sensed].copy()

    def trace(self, actions: np.ndarray, most_rest: int) -> np.ndarray:
        """Play actions and rest; returns the sensors after every step, float64 (steps, size)."""
        played = self._player.play(np.clip(actions, -1.0, 1.0), most_rest, self._tolerance, True)
        self._note(played)
        assert played.visited is not None
        return played.visited[:, self._sensed]

    # ---- what the protocol does not ask for -----------------------------------------------------

    def happened(self) -> Events:
        """What happened since the last restore or reset."""
        last = self._last
        if last is None:
            return Events(frozenset(), np.zeros(0), False, 0, False)
        return Events(self._touched, last.positions, self._terminated, last.rest_steps, last.still)

    def limit(self, start: Situation, sequence: np.ndarray) -> np.ndarray:
        """Scale a sequence so that no order of it can reach a stop from `start`."""
        if not self.avoid_stops:
            return sequence
        return sequence * (_scale_within(sequence, start) * (1 - ROUNDING))

    def reaches_stop(self, start: Situation, sequence: np.ndarray) -> bool:
        """Whether some order of a sequence could reach a stop from `start`."""
        return bool((_scale_within(sequence, start) < 1 - ROUNDING).any())

    def has_inverse(self) -> np.ndarray:
        """For which actions the opposite action leads back, as far as the control knows."""
        return self.control.has_inverse()

    def reseed(self, seed: int) -> None:
        """Give the environment's generator another state: whether steps are noisy shows then."""
        self._player.reseed(seed)

    def distance(self, first: np.ndarray, second: np.ndarray) -> float:
        """Root mean square of the differences, each in units of its sensor.

        Sensors that never moved on the way to starts, such as goals, do not count, unless the two
        observations differ in them: then they do, in the median unit of the others.
        """
        return scaled_difference(first, second, self.unit)

    def close(self) -> None:
        """Give the environment back as it was: its actuators, and its limit of steps."""
        restore_actuators(self.env)
        for wrapper, limit in self._limits:
            wrapper._max_episode_steps = limit
        if isinstance(self._player, RemotePlayer):
            self._player.close()

    def enter_process(self) -> None:
        """Prepare for use in a process that was forked from the one that made this world."""
        if isinstance(self._player, RemotePlayer):
            self._player = RemotePlayer(self._local)
            self._keep_pristine()

    @property
    def observes_images(self) -> bool:
        """Whether observations are images."""
        return self._pixels

    @property
    def knows_contacts(self) -> bool:
        """Whether the simulator tells what touches what."""
        return self._player.contacts.known

    # ---- internals ------------------------------------------------------------------------------

    def _keep_pristine(self) -> None:
        """Keep the situation before all episodes, since some resets do not forget everything."""
        self._player.reset(0)
        self._pristine = self._player.snapshot()

    def _go_to_start(self, rng: np.random.Generator, keep: bool = False) -> Played:
        seed, n = int(rng.integers(2**31)), self.control.n
        actions = rng.uniform(-1, 1, (-(-self._prefix // self._hold), n)).repeat(self._hold, 0)
        actions = np.concatenate([actions[: self._prefix], np.zeros((self._settle, n))])
        self._touched, self._terminated = frozenset(), False
        if self._pristine is not None:
            self._player.restore(self._pristine)
        first = self._player.reset(seed)
        if self.approach is not None:
            played = self._player.play(np.zeros((0, n)))
            for _ in range(self._prefix):
                action = np.clip(self.approach(played.observation, rng), -1.0, 1.0)
                played = self._player.play(action[None])
                self._note(played)
            actions = actions[self._prefix :]
        played = self._player.play(actions, 0, None, keep)
        self._note(played)
        if keep and played.visited is not None:
            visited = np.concatenate([first[None], played.visited])
            return played._replace(visited=visited)
        return played

    def _note(self, played: Played) -> None:
        self._last = played
        self._observation = played.observation
        self._touched |= played.touched
        self._terminated = self._terminated or played.terminated

    def _measure_unit(self) -> None:
        ways = []
        for i in range(UNIT_STARTS):
            visited = self._go_to_start(generator(0, "unit", i), keep=True).visited
            assert visited is not None
            ways.append(visited)
        moves = np.any([np.ptp(way, axis=0) > 0 for way in ways], axis=0)
        visited = np.concatenate(ways)
        spread = visited.std(axis=0)
        self._tolerance = np.where(moves, STILL * spread, np.inf)
        self._spread = np.where(np.ptp(visited, axis=0) > 0, spread, np.inf)
        self.unit = np.where(moves, spread, np.inf)[self._sensed]

    def _keep_sensors(self, which: np.ndarray) -> None:
        """Compare only the sensors of a mask, bool (size,).

        If none of them moves on the way to starts, their units are their spread over the starts.
        """
        self.choices.append(f"{which.sum()} of {len(which)} sensors are of the world")
        self._sensed = self._sensed[which]
        unit = self.unit[which]
        self.unit = unit if np.isfinite(unit).any() else self._spread[self._sensed]


def from_gymnasium(env: gymnasium.Env, **options: Any) -> GymnasiumWorld:
    """Return a Gymnasium environment as a world; `options` as for :class:`GymnasiumWorld`."""
    return GymnasiumWorld(env, **options)


def _lift_limits(env: gymnasium.Env) -> list[tuple[Any, Any]]:
    """Let episodes go on, since an order may be longer than the episodes of a task; returns the
    wrappers with the limits that they had."""
    wrapper: Any = env
    lifted = []
    while isinstance(wrapper, gymnasium.Wrapper):
        if isinstance(wrapper, gymnasium.wrappers.TimeLimit):
            lifted.append((wrapper, wrapper._max_episode_steps))
            wrapper._max_episode_steps = NO_LIMIT
        wrapper = wrapper.env
    return lifted


def _check_way(prefix: Any, hold: Any, settle: Any) -> None:
    for name, value, least in (("prefix", prefix, 0), ("hold", hold, 1), ("settle", settle, 0)):
        if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < least:
            raise ArgumentError(
                f"{name}: expected a whole number of at least {least}, got {value!r}"
            )


def _scale_within(sequence: np.ndarray, start: Situation) -> np.ndarray:
    """Factor of each action, at most 1, with which neither the positive nor the negative part of
    the sequence alone reaches a stop: then no order of it does."""
    up = np.clip(sequence, 0, None).sum(axis=0)
    down = np.clip(-sequence, 0, None).sum(axis=0)
    scale = np.ones(len(up))
    for room, part in ((start.up, up), (start.down, down)):
        commanded = part > 0
        scale[commanded] = np.minimum(scale[commanded], room[commanded] / part[commanded])
    return scale


def _name_dofs(env: gymnasium.Env, n: int) -> tuple[Dof, ...]:
    """One degree of freedom per action, named after MuJoCo's actuator, or else after its joint."""
    names = [f"action-{i}" for i in range(n)]
    simulator = find_mujoco(env)
    if simulator is not None and simulator.model.nu == n:
        import mujoco

        model, kinds = simulator.model, mujoco.mjtObj
        on_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
        found = [mujoco.mj_id2name(model, kinds.mjOBJ_ACTUATOR, i) or "" for i in range(n)]
        for i in np.flatnonzero(on_joint):
            joint = mujoco.mj_id2name(model, kinds.mjOBJ_JOINT, int(model.actuator_trnid[i, 0]))
            found[i] = found[i] or joint or ""
        if all(found) and len(set(found)) == n:
            names = found
    return tuple(Dof(name, "1", 1.0) for name in names)
