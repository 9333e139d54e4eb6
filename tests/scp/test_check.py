"""check_world finds every broken promise, and passes worlds that keep them."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity import ArgumentError, Corridor, Dof, WorldError, check_world
from sensory_commutativity.worlds.flatland.room import Room
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

SEEDS = range(20)


class Wrapped:
    """A world that does what another does."""

    def __init__(self, world=None):
        self.world = world or Corridor(wall=3, box=2)
        self.dofs = self.world.dofs

    def reset(self, rng):
        self.world.reset(rng)

    def snapshot(self):
        return self.world.snapshot()

    def restore(self, snapshot):
        self.world.restore(snapshot)

    def step(self, action):
        self.world.step(action)

    def observe(self):
        return self.world.observe()


class RestoresNothing(Wrapped):
    def restore(self, snapshot):
        pass


class RestoresPartly(Wrapped):
    """Has a counter that the snapshot forgets."""

    steps = 0

    def reset(self, rng):
        super().reset(rng)
        self.steps = 0

    def step(self, action):
        super().step(action)
        self.steps += 1

    def observe(self):
        return np.append(super().observe(), self.steps)


class ForgetsVelocity(Wrapped):
    """Moves with a hidden velocity that is not part of the snapshot."""

    velocity = 0.0
    position = 0.0

    def reset(self, rng):
        super().reset(rng)
        self.velocity = self.position = 0.0

    def snapshot(self):
        return super().snapshot(), self.position

    def restore(self, snapshot):
        inner, self.position = snapshot
        super().restore(inner)

    def step(self, action):
        super().step(action)
        self.velocity += 0.1 * float(np.clip(action[0], -1, 1))
        self.position += self.velocity

    def observe(self):
        return np.append(super().observe(), self.position)


class ObservesBeforeTheStep(Wrapped):
    def reset(self, rng):
        super().reset(rng)
        self.observation = super().observe()

    def step(self, action):
        self.observation = super().observe()
        super().step(action)

    def observe(self):
        return self.observation.copy()


class ObservesTheStart(ObservesBeforeTheStep):
    def step(self, action):
        self.world.step(action)


class ReturnsOneBuffer(Wrapped):
    def __init__(self, world=None):
        super().__init__(world)
        self.world.reset(np.random.default_rng())
        self.buffer = self.world.observe()

    def observe(self):
        self.buffer[...] = super().observe()
        return self.buffer


class ReturnsItsState(Wrapped):
    def reset(self, rng):
        super().reset(rng)
        self.state = super().observe()

    def restore(self, snapshot):
        super().restore(snapshot)
        self.state = super().observe()

    def step(self, action):
        super().step(action)
        self.state = super().observe()

    def observe(self):
        return self.state


class HasNoisySensors(Wrapped):
    rng = np.random.default_rng(1)

    def observe(self):
        observation = super().observe()
        return observation + 1e-9 * self.rng.normal(size=observation.shape)


class HasNoisySteps(Wrapped):
    rng, drift = np.random.default_rng(1), 0.0

    def restore(self, snapshot):
        inner, self.drift = snapshot
        super().restore(inner)

    def snapshot(self):
        return super().snapshot(), self.drift

    def reset(self, rng):
        super().reset(rng)
        self.drift = 0.0

    def step(self, action):
        super().step(action)
        self.drift += 1e-6 * self.rng.normal()

    def observe(self):
        return np.append(super().observe(), self.drift)


class ObservesNan(Wrapped):
    steps = 0

    def step(self, action):
        super().step(action)
        self.steps += 1

    def observe(self):
        observation = super().observe().astype(float)
        if self.steps % 7 == 6:
            observation[0] = np.nan
        return observation


class ChangesShape(ObservesNan):
    def observe(self):
        observation = Wrapped.observe(self)
        return observation[:-1] if self.steps % 7 == 6 else observation


class ChangesType(ObservesNan):
    def observe(self):
        observation = Wrapped.observe(self)
        return observation.astype(np.float32) if self.steps % 7 == 6 else observation


class StartsAnywhere(Wrapped):
    def reset(self, rng):
        super().reset(rng)
        self.start = np.random.default_rng().uniform()

    def observe(self):
        return np.append(super().observe(), self.start)


class DoesNotClip(Wrapped):
    position = 0.0

    def reset(self, rng):
        self.position = 0.0
        super().reset(rng)

    def snapshot(self):
        return super().snapshot(), self.position

    def restore(self, snapshot):
        inner, self.position = snapshot
        super().restore(inner)

    def step(self, action):
        super().step(action)
        self.position += action[0]

    def observe(self):
        return np.append(super().observe(), self.position)


class PlaysOtherwise(Wrapped):
    def play(self, actions):
        for action in actions[1:]:
            self.step(action)


class ReturnsADictionary(Wrapped):
    def observe(self):
        return {"cell": super().observe()}


class ReturnsAList(Wrapped):
    def observe(self):
        return [1, [2, 3]]


BROKEN = {
    RestoresNothing: "restore",
    RestoresPartly: "restore",
    ForgetsVelocity: "replay",
    ObservesBeforeTheStep: "fresh observation",
    ObservesTheStart: "fresh observation",
    ReturnsOneBuffer: "aliasing",
    ReturnsItsState: "aliasing",
    HasNoisySensors: "repeatable observation",
    HasNoisySteps: "replay",
    ObservesNan: "observations",
    ChangesShape: "observations",
    ChangesType: "observations",
    StartsAnywhere: "reset",
    DoesNotClip: "clipping",
    ReturnsADictionary: "observations",
    ReturnsAList: "observations",
}


@pytest.mark.parametrize("broken", BROKEN, ids=lambda cls: cls.__name__)
def test_every_broken_promise_is_found_and_named(broken: type[Wrapped]) -> None:
    for seed in SEEDS:
        report = check_world(broken(), tries=5, seed=seed)
        assert BROKEN[broken] in [result.name for result in report.failed], str(report)
        with pytest.raises(WorldError, match=broken.__name__):
            report.raise_if_failed()


@pytest.mark.parametrize(
    "broken",
    [RestoresNothing, ObservesBeforeTheStep, ReturnsOneBuffer, HasNoisySensors, ObservesNan,
     PlaysOtherwise],
    ids=lambda cls: cls.__name__,
)  # fmt: skip
def test_broken_promises_are_found_in_flatland(broken: type[Wrapped]) -> None:
    world = FlatlandWorld(Room(objects=2))
    for seed in SEEDS:
        failed = [r.name for r in check_world(broken(world), tries=1, seed=seed).failed]
        assert failed == [BROKEN.get(broken, "play")]


@pytest.mark.parametrize(
    "world",
    [Corridor(), Corridor(wall=3, box=2), FlatlandWorld(), Wrapped()],
    ids=["corridor", "corridor with box", "flatland", "wrapped"],
)
def test_worlds_that_keep_their_promises_pass(world) -> None:
    report = check_world(world)
    assert report.passed, str(report)
    assert not report.warnings and report.raise_if_failed() is None


def test_a_dead_degree_of_freedom_is_a_warning() -> None:
    world = Wrapped()
    world.dofs = (*world.dofs[:1], Dof("eyelid", "1", 1.0), Dof("tail", "1", 1.0))
    world.step = lambda action: Wrapped.step(world, action[:2])
    report = check_world(world)
    assert report.passed and len(report.warnings) == 1 and "tail" in report.warnings[0]


@pytest.mark.parametrize("dofs", [(), ("move", "eyelid"), 2, (Dof("a", "1", 1), Dof("a", "1", 1))])
def test_wrong_degrees_of_freedom_are_named(dofs) -> None:
    world = Wrapped()
    world.dofs = dofs
    assert [result.name for result in check_world(world, 1).failed] == ["dofs"]


def test_what_is_no_world_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"int has no reset, snapshot, .* dofs"):
        check_world(3)
    with pytest.raises(ArgumentError, match=r"Corridor\(\.\.\.\)"):
        check_world(Corridor)
    with pytest.raises(ArgumentError, match=r"tries"):
        check_world(Corridor(), tries=0)


def test_the_report_says_what_failed_why_and_the_remedy() -> None:
    text = str(check_world(RestoresNothing(), tries=3))
    assert "RestoresNothing cannot be measured" in text
    assert "FAILED      restore" in text and "in 3 of 3" in text and "remedy: " in text
    assert "not tested  replay" in text
