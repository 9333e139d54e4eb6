"""Exact snapshots: which way is exact where, and that the self-test finds what is not."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from sensory_commutativity import (
    ArgumentError,
    ExactSnapshot,
    WorldError,
    choose_snapshots,
    make_environment,
    measure_exactness,
)
from sensory_commutativity.adapters.snapshots import NativeSnapshots, ReplaySnapshots

MUJOCO = ["HalfCheetah-v5", "Pusher-v5", "FetchPush-v4", "AdroitHandDoor-v1",
          "dm_control/cheetah-run-v0"]  # fmt: skip


@pytest.mark.parametrize("name", MUJOCO)
def test_copies_of_mujoco_are_exact(name: str) -> None:
    result = measure_exactness(make_environment(name), "native", tries=5)
    assert result.exact == 5, str(result)


@pytest.mark.parametrize("name", ["BipedalWalker-v3", "PandaReach-v3", "Reacher-v5"])
def test_forked_processes_are_exact(name: str) -> None:
    result = measure_exactness(make_environment(name), "fork", tries=3)
    assert result.exact == 3, str(result)


class HasNoise(gym.Wrapper):
    """Adds noise that no seed determines."""

    def step(self, action):
        observation, *rest = super().step(action)
        return observation + 1e-9 * np.random.default_rng().normal(size=len(observation)), *rest


class RestoresNothing(ReplaySnapshots):
    def restore(self, snapshot):
        pass


@pytest.mark.parametrize("seed", range(20))
def test_the_self_test_finds_what_is_not_exact(seed: int) -> None:
    env = gym.make("Pendulum-v1")
    normalized = gym.wrappers.NormalizeObservation(env)
    noisy = HasNoise(env)
    for broken, way in ((normalized, "replay"), (noisy, "replay"), (noisy, "native"),
                        (env, RestoresNothing)):  # fmt: skip
        result = measure_exactness(broken, way, seed=seed)
        assert result.exact < result.tries and not result.error, str(result)


def test_the_cheapest_exact_way_is_chosen() -> None:
    env = gym.wrappers.NormalizeObservation(gym.make("Pendulum-v1"))
    snapshots, tried = choose_snapshots(env)
    assert isinstance(snapshots, NativeSnapshots) and [one.way for one in tried] == ["native"]
    _, tried = choose_snapshots(make_environment("PandaPush-v3"), tries=3)
    assert [one.way for one in tried][-1] == "fork" and tried[0].error
    with pytest.raises(WorldError, match=r"cannot be restored exactly \(replay 0 of 20\)"):
        choose_snapshots(env, "replay")
    with pytest.raises(ArgumentError, match=r"way: expected auto or one of native, replay, fork"):
        choose_snapshots(env, "deepcopy")


@pytest.mark.parametrize("way", ["native", "replay", "fork"])
def test_the_wrapper_goes_back_as_often_as_needed(way: str) -> None:
    env = ExactSnapshot(gym.make("Pendulum-v1"), way)
    env.reset(seed=3)
    actions = np.linspace(-2, 2, 12, dtype=np.float32)[:, None]
    starts, endings = [env.snapshot()], []
    for action in actions[:5]:
        env.step(action)
    starts.append(env.snapshot())
    for start in (1, 0, 1, 0):
        env.restore(starts[start])
        endings.append(np.array([env.step(action)[0] for action in actions]))
    assert np.array_equal(endings[0], endings[2]) and np.array_equal(endings[1], endings[3])
    assert not np.array_equal(endings[0], endings[1])
    with env.restored():
        env.step(actions[0])
    again = env.step(actions[0])[0]
    env.restore(starts[0])
    for action in actions:
        env.step(action)
    assert np.array_equal(env.step(actions[0])[0], again)
    env.close()


def test_an_error_in_the_other_process_is_told() -> None:
    env = ExactSnapshot(gym.make("Pendulum-v1"), "fork")
    env.reset(seed=0)
    with pytest.raises(WorldError, match=r"ValueError|AssertionError|TypeError|IndexError"):
        env.step("forward")
    env.close()
