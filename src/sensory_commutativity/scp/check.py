"""Checks that a world keeps the promises that the SC-experiment rests on.

A world whose ``restore`` does nothing, or whose sensors are noisy, gives an SCP like any other; it
is only wrong. :func:`check_world` plays random sequences and says which promise is broken and why.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ArgumentError, WorldError
from ..seeding import generator
from .experiment import REST_STEPS
from .sequences import compose, no_op
from .world import Dof, SequencePlayer, World, play

METHODS = ("reset", "snapshot", "restore", "step", "observe")

PROMISES = {
    "dofs": "dofs is a non-empty tuple of Dof with different names",
    "observations": "observations are arrays of finite numbers, of one shape and type",
    "aliasing": "an observation that was returned never changes, and may be changed",
    "repeatable observation": "observing twice without a step gives the same",
    "reset": "reset draws from its generator only: the same seed gives the same start",
    "restore": "restore returns to the situation of the snapshot",
    "replay": "the same actions from the same snapshot give the same observations",
    "fresh observation": "observations show the present situation",
    "clipping": "an action beyond [-1, 1] does what the nearest action within does",
    "play": "play does the same as single steps",
}
"""Name of a check -> what holds where it passes."""

_REMEDIES = {
    "dofs": "set dofs to (Dof('name', 'unit', speed), ...)",
    "observations": "return np.asarray of finite numbers, always of the same shape and dtype",
    "aliasing": "return a copy: observation.copy()",
    "repeatable observation": "draw sensor noise from a generator that is part of the snapshot, "
    "or turn it off",
    "reset": "draw everything random from rng",
    "restore": "put everything that step and observe read into the snapshot, as a copy",
    "replay": "put everything that step and observe read into the snapshot: velocities, "
    "controllers, contacts, generators",
    "fresh observation": "compute the observation in observe(), or update it at the end of step "
    "and of restore",
    "clipping": "begin step with action = np.clip(action, -1, 1)",
    "play": "let play call step for every action, or leave it out",
}


class _BrokenPromise(Exception):
    """A check failed: its name, and the reason."""

    def __init__(self, check: str, reason: str):
        super().__init__(check, reason)
        self.check, self.reason = check, reason


@dataclass(frozen=True)
class CheckResult:
    """Result of one check of a world.

    Attributes
    ----------
    name : str
        A key of ``PROMISES``.
    tries : int
        Tries that came as far as this check; a try ends with the first promise that is broken.
    failures : int
        Tries in which the promise was broken.
    reason : str
        Why, in the first of them; empty if there is none.
    """

    name: str
    tries: int
    failures: int
    reason: str

    @property
    def passed(self) -> bool:
        return self.failures == 0

    @property
    def status(self) -> str:
        """``ok``, ``FAILED``, or ``not tested``."""
        return "FAILED" if self.failures else "ok" if self.tries else "not tested"


@dataclass(frozen=True)
class WorldReport:
    """What :func:`check_world` found.

    Attributes
    ----------
    world : str
        Name of the world's class.
    tries : int
        Random starts that were tried.
    results : tuple of CheckResult
        One per check.
    warnings : tuple of str
        What breaks no promise and is probably not meant.
    """

    world: str
    tries: int
    results: tuple[CheckResult, ...]
    warnings: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every promise was kept in every try."""
        return all(result.passed for result in self.results)

    @property
    def failed(self) -> tuple[CheckResult, ...]:
        """The checks that failed, in the order in which they are listed."""
        return tuple(result for result in self.results if not result.passed)

    def raise_if_failed(self) -> None:
        """Raise WorldError with the first promise that was broken, if any."""
        for result in self.failed:
            raise WorldError(
                f"{self.world} breaks a promise ({result.name}): {result.reason}; "
                f"{_REMEDIES[result.name]}"
            )

    def __str__(self) -> str:
        ended = "keeps all promises" if self.passed else "cannot be measured"
        lines = [f"{self.world} {ended} ({self.tries} random starts)"]
        for result in self.results:
            lines.append(f"  {result.status:10}  {result.name}: {PROMISES[result.name]}")
            if not result.passed:
                lines.append(f"{'':14}in {result.failures} of {self.tries}: {result.reason}")
                lines.append(f"{'':14}remedy: {_REMEDIES[result.name]}")
        lines += [f"  {'warning':10}  {text}" for text in self.warnings]
        return "\n".join(lines)

    __repr__ = __str__


def check_world(
    world: World, tries: int = 20, length: int = 10, seed: int = 0, rest_steps: int = REST_STEPS
) -> WorldReport:
    """Check that a world keeps the promises that the SC-experiment rests on.

    Every try resets the world, plays a random sequence of all degrees of freedom, another one, and
    the first again.

    Parameters
    ----------
    world : World
        Is reset.
    tries : int
        Random starts.
    length : int
        Actions in a sequence.
    seed : int
        Determines starts and sequences.
    rest_steps : int
        Steps without a command at the end of a sequence.

    Returns
    -------
    WorldReport
        Printed, it is a list of all checks; ``raise_if_failed()`` raises an exception.

    Raises
    ------
    ArgumentError
        If `world` lacks a method, or a number is not positive.
    """
    require_world(world)
    for name, value in (("tries", tries), ("length", length), ("rest_steps", rest_steps)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not whole or value < (0 if name == "rest_steps" else 1):
            raise ArgumentError(f"{name}: expected a whole number of at least 1, got {value!r}")
    tested = dict.fromkeys(PROMISES, 0)
    failures = dict.fromkeys(PROMISES, 0)
    reasons = dict.fromkeys(PROMISES, "")
    trials = _Trials(world, seed, length, rest_steps)
    for i in range(tries):
        trials.kept = set()
        try:
            trials.run(i)
        except _BrokenPromise as broken:
            failures[broken.check] += 1
            reasons[broken.check] = reasons[broken.check] or broken.reason
            trials.kept.add(broken.check)
        for name in trials.kept:
            tested[name] += 1
    results = tuple(
        CheckResult(name, tested[name], failures[name], reasons[name]) for name in PROMISES
    )
    warnings = () if any(failures.values()) else tuple(trials.warnings())
    return WorldReport(type(world).__name__, tries, results, warnings)


def require_world(world: Any, argument: str = "world") -> None:
    """Raise ArgumentError if `world` lacks what the protocol World asks for."""
    if inspect.isclass(world):
        raise ArgumentError(
            f"{argument}: expected a world, got the class {world.__name__}; write "
            f"{world.__name__}(...)"
        )
    if hasattr(world, "action_space"):
        raise ArgumentError(
            f"{argument}: {type(world).__name__} is a Gymnasium environment; write "
            "from_gymnasium(env)"
        )
    missing = [name for name in METHODS if not callable(getattr(world, name, None))]
    missing += [] if hasattr(world, "dofs") else ["dofs"]
    if missing:
        raise ArgumentError(
            f"{argument}: {type(world).__name__} has no {', '.join(missing)}; a world has dofs and "
            f"the methods {', '.join(METHODS)}"
        )


class _Trials:
    """Tries of one world; remembers what the first observation looked like, and what moved."""

    def __init__(self, world: World, seed: int, length: int, rest_steps: int):
        self.world, self.seed, self.length, self.rest_steps = world, seed, length, rest_steps
        self.form: tuple[tuple[int, ...], np.dtype] | None = None
        self.kept: set[str] = set()
        self.visible: dict[str, bool] = {}

    def run(self, i: int) -> None:
        """Raise _BrokenPromise for the first promise that is broken."""
        world = self.world
        self._check_dofs()
        n = len(world.dofs)
        rng = generator(self.seed, "check", i)
        sequence = rng.uniform(-1, 1, (self.length, n))
        other = rng.uniform(-1, 1, (self.length, n))
        rest = no_op(self.rest_steps, n)

        world.reset(generator(self.seed, "check start", i))
        returned, first = self._observe_without_step()
        self._check_reset(i, first)
        start = world.snapshot()
        observations = [first, *self._play_by_steps(compose(sequence, rest))]
        if not _equal(returned, first):
            raise _BrokenPromise("aliasing", "an observation changed while the world went on")
        self._check_restore(start, first, observations, other, rng)
        self._check_replay(start, compose(sequence, rest), observations)
        self._check_fresh(observations)
        self._check_ending(start, compose(sequence, rest), observations[-1])
        self.kept |= {"observations", "aliasing"}
        beyond = np.sign(other) * (1 + np.abs(other))
        self._check_clipping(start, compose(beyond, rest))
        self._try_dof(start, i % n, rng)

    def warnings(self) -> Iterator[str]:
        """Degrees of freedom that no observation ever showed."""
        for name, visible in self.visible.items():
            if not visible:
                yield f"no observation showed that {name} was commanded"

    # ---- the checks -----------------------------------------------------------------------------

    def _check_dofs(self) -> None:
        dofs = self.world.dofs
        try:
            names = [dof.name for dof in dofs]
        except (AttributeError, TypeError):
            kind = type(dofs).__name__
            raise _BrokenPromise("dofs", f"dofs is a {kind} without names") from None
        if not names:
            raise _BrokenPromise("dofs", "there is no degree of freedom")
        if len(set(names)) < len(names):
            raise _BrokenPromise("dofs", f"two have the same name: {', '.join(names)}")
        if not all(isinstance(dof, Dof) for dof in dofs):
            raise _BrokenPromise("dofs", "an element is not a Dof")
        self.kept.add("dofs")

    def _check_reset(self, i: int, first: np.ndarray) -> None:
        """That the start whose observation is `first` comes again."""
        rng = generator(self.seed, "check reset", i)
        self._play_by_steps(rng.uniform(-1, 1, (2, len(self.world.dofs))))
        self.world.reset(generator(self.seed, "check start", i))
        if not _equal(first, self._observe()):
            raise _BrokenPromise("reset", "two resets with the same seed gave other observations")
        self.kept.add("reset")

    def _observe_without_step(self) -> tuple[np.ndarray, np.ndarray]:
        """An observation as it was returned, and a copy of it."""
        first = self._observe()
        again = self.world.observe()
        if not _equal(first, again):
            raise _BrokenPromise(
                "repeatable observation", "two observations without a step between them differ"
            )
        self.kept.add("repeatable observation")
        try:
            again[...] = np.roll(again, 1) + np.ones((), again.dtype)  # anything else
        except ValueError:  # read-only, which is safe
            pass
        else:
            if not _equal(first, self._observe()):
                raise _BrokenPromise("aliasing", "writing into an observation changed the next one")
        return self.world.observe(), first

    def _check_restore(
        self, start: Any, first: np.ndarray, observations: list[np.ndarray], other: np.ndarray,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        world = self.world
        before = observations[-1]
        for actions in (None, other):
            if actions is not None:
                before = self._play_by_steps(actions)[-1]
            world.restore(start)
            after = self._observe()
            if _equal(after, first):
                continue
            # Either the situation is not restored, or it is and the sensors do not show it yet.
            if _equal(after, before) and self._is_restored(start, rng):
                raise _BrokenPromise(
                    "fresh observation",
                    "after restore, the observation is still that from before",
                )
            unchanged = "is that from before the call" if _equal(after, before) else "is another"
            raise _BrokenPromise(
                "restore", f"after restore, the observation {unchanged}, not that of the snapshot"
            )
        self.kept.add("restore")

    def _is_restored(self, start: Any, rng: np.random.Generator) -> bool:
        """Whether the same actions from `start` end equal, whatever is played in between."""
        n = len(self.world.dofs)
        actions = rng.uniform(-1, 1, (self.length, n))
        endings = []
        for between in (0, 1, 4, 2):
            self._play_by_steps(rng.uniform(-1, 1, (between, n)))
            self.world.restore(start)
            endings.append(self._play_by_steps(actions)[-1])
        return all(_equal(ending, endings[0]) for ending in endings)

    def _check_replay(
        self, start: Any, sequence: np.ndarray, observations: list[np.ndarray]
    ) -> None:
        self.world.restore(start)
        for k, observation in enumerate(self._play_by_steps(sequence), 1):
            if not _equal(observation, observations[k]):
                difference = np.max(np.abs(
                    observation.astype(float) - observations[k].astype(float)))  # fmt: skip
                raise _BrokenPromise(
                    "replay",
                    f"the same actions ended elsewhere after {k} of {len(sequence)} steps "
                    f"(largest difference {difference:.3g})",
                )
        self.kept.add("replay")

    def _check_fresh(self, observations: list[np.ndarray]) -> None:
        if all(_equal(observation, observations[0]) for observation in observations):
            raise _BrokenPromise(
                "fresh observation",
                f"no observation changed in {len(observations) - 1} steps that commanded all "
                "degrees of freedom",
            )
        self.kept.add("fresh observation")

    def _check_ending(self, start: Any, sequence: np.ndarray, expected: np.ndarray) -> None:
        """That :func:`.play`, without observations on the way, ends where single steps do."""
        self.world.restore(start)
        argument = sequence.copy()
        play(self.world, argument)
        ended = self._observe()
        if not np.array_equal(argument, sequence):
            raise _BrokenPromise("aliasing", "the world changed the actions that it was given")
        if not _equal(ended, expected):
            if isinstance(self.world, SequencePlayer):
                raise _BrokenPromise("play", "play ended elsewhere than single steps")
            raise _BrokenPromise(
                "replay", "a sequence ended elsewhere when nobody observed on the way"
            )
        if isinstance(self.world, SequencePlayer):
            self.kept.add("play")

    def _check_clipping(self, start: Any, beyond: np.ndarray) -> None:
        endings = []
        for actions in (beyond, np.clip(beyond, -1, 1)):
            self.world.restore(start)
            try:
                endings.append(self._play_by_steps(actions)[-1])
            except (ValueError, AssertionError) as error:
                raise _BrokenPromise(
                    "clipping", f"step refuses an action beyond 1 ({_one_line(error)})"
                ) from None
        if not _equal(*endings):
            raise _BrokenPromise("clipping", "actions of up to 2 moved further than actions of 1")
        self.kept.add("clipping")

    def _try_dof(self, start: Any, dof: int, rng: np.random.Generator) -> None:
        """Note whether observations show that a degree of freedom is commanded."""
        name = self.world.dofs[dof].name
        actions = np.zeros((self.length, len(self.world.dofs)))
        actions[:, dof] = rng.choice([-1.0, 1.0], self.length)
        self.world.restore(start)
        commanded = self._play_by_steps(actions)
        self.world.restore(start)
        pairs = zip(commanded, self._play_by_steps(np.zeros_like(actions)), strict=True)
        changed = not all(_equal(*pair) for pair in pairs)
        self.visible[name] = self.visible.get(name, False) or changed

    # ---- playing and observing ------------------------------------------------------------------

    def _play_by_steps(self, actions: np.ndarray) -> list[np.ndarray]:
        """A copy of the observation after every step."""
        observations = []
        for action in actions:
            self.world.step(action)
            observations.append(self._observe())
        return observations

    def _observe(self) -> np.ndarray:
        """A copy of the present observation, whose form is checked."""
        observation: Any = self.world.observe()
        if not isinstance(observation, np.ndarray):
            raise _BrokenPromise("observations", _describe_non_array(observation))
        if observation.dtype.kind not in "biuf":
            raise _BrokenPromise("observations", f"the dtype {observation.dtype} is not a number")
        if not np.isfinite(observation).all():
            raise _BrokenPromise("observations", "an observation holds NaN or infinity")
        form = observation.shape, observation.dtype
        self.form = self.form or form
        if form != self.form:
            raise _BrokenPromise(
                "observations",
                f"the first was {self.form[1]} {self.form[0]}, a later one {form[1]} {form[0]}",
            )
        return observation.copy()


def _describe_non_array(observation: Any) -> str:
    kind = type(observation).__name__
    if isinstance(observation, dict):
        return f"observe returned a {kind} with the keys {', '.join(map(str, observation))}"
    return f"observe returned a {kind}, not an array"


def _equal(first: np.ndarray, second: np.ndarray) -> bool:
    return first.shape == second.shape and bool(np.array_equal(first, second))


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:80]
