"""What the report says of environments whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity import (
    ArgumentError,
    Measurement,
    from_gymnasium,
    make_environment,
    measure,
)


def verdicts(measurement: Measurement, threshold: float) -> dict[str, str]:
    table = measurement.table
    rows = table[table["threshold"] == threshold]
    return dict(zip(rows["dof"], rows["verdict"], strict=True))


def test_torques_are_forces_and_a_servo_commutes() -> None:
    direct = from_gymnasium(make_environment("Reacher-v5"), control="direct")
    forces = measure(direct, n=30, length=30, thresholds=0.1, rest_steps=0)
    assert max(forces.scp().values()) < 0.3
    assert set(verdicts(forces, 0.1).values()) == {
        "no effect on the world shown: actions are like forces"
    }
    servo = from_gymnasium(make_environment("Reacher-v5"))
    assert servo.control.name == "servo"
    free = measure(servo, n=30, length=30, thresholds=1e-3)
    assert set(free.scp().values()) == {1.0}
    assert "control servo (2 of 2 actuators are motors)" in str(free)


def test_stops_are_avoided_or_named() -> None:
    pusher = from_gymnasium(make_environment("Pusher-v5"))
    free = measure(pusher, n=15, length=30, thresholds=1e-3)
    assert min(free.table["scp_untouched"]) >= 0.9
    stops = from_gymnasium(make_environment("Pusher-v5"), avoid_stops=False)
    stopped = measure(stops, n=15, length=30, thresholds=1e-3)
    assert stopped.table["reaches_stop"].max() > 0.5
    assert any("stops" in verdict for verdict in verdicts(stopped, 1e-3).values())


def test_a_blocked_gripper_is_dead() -> None:
    world = from_gymnasium(make_environment("FetchReach-v4"))
    fetch = measure(world, n=4, length=10, thresholds=0.0, rest_steps=5)
    assert verdicts(fetch, 0.0)["action-3"].startswith("dead")
    assert fetch.scp()["action-3"] == 1.0


def test_what_terminates_or_is_noisy_is_undefined() -> None:
    hopper = measure(from_gymnasium(make_environment("Hopper-v5"), control="direct"), n=5,
                     length=30, rest_steps=0)  # fmt: skip
    assert all("terminate" in text for text in verdicts(hopper, 0.1).values())
    lander = measure(from_gymnasium(make_environment("LunarLanderContinuous-v3")), n=10, length=20,
                     rest_steps=0)  # fmt: skip
    assert all(text.startswith("undefined") for text in verdicts(lander, 0.1).values())


def test_workers_resume_and_files_keep_the_controls(tmp_path) -> None:
    world = from_gymnasium(make_environment("Reacher-v5"))
    file = tmp_path / "reacher.parquet"
    whole = measure(world, n=8, length=5)
    measure(world, n=5, length=5, resume=file)
    resumed = measure(world, n=8, length=5, resume=file, workers=2)
    for measurement in (resumed, Measurement.load(file)):
        assert np.array_equal(measurement.distances, whole.distances)
        for name, values in whole.controls.items():
            assert np.array_equal(measurement.controls[name], values, equal_nan=True), name
        assert str(measurement) == str(whole)


def test_an_environment_can_be_measured_again_and_by_several_workers() -> None:
    env = make_environment("Reacher-v5")
    first = measure(env, n=6, length=5)
    for again in (measure(env, n=6, length=5), measure(env, n=6, length=5, workers=2),
                  measure(make_reacher, n=6, length=5, workers=2)):  # fmt: skip
        assert again.choices == first.choices
        assert np.array_equal(again.distances, first.distances)


def make_reacher():
    return make_environment("Reacher-v5")


def test_a_forked_environment_is_measured_by_several_workers() -> None:
    world = from_gymnasium(make_environment("BipedalWalker-v3"), snapshots="fork", tries=2)
    alone = measure(world, n=4, length=5, rest_steps=5)
    assert np.array_equal(
        measure(world, n=4, length=5, rest_steps=5, workers=2).distances, alone.distances
    )


def test_pixels_are_a_sensor() -> None:
    env = make_environment("Pendulum-v1", render_mode="rgb_array")
    world = from_gymnasium(env, sensors=["pixels"])
    world.reset(np.random.default_rng(0))
    image = world.observe()
    assert image.shape == (128, 128, 3) and image.dtype == np.uint8
    assert measure(world, n=2, length=3, rest_steps=2).settings.distance == "mse"
    with pytest.raises(ArgumentError, match="distance: scaled needs"):
        measure(world, n=2, distance="scaled")


def test_starts_can_be_chosen() -> None:
    world = from_gymnasium(
        make_environment("FetchPush-v4"), snapshots="replay", tries=1, prefix=10, settle=0,
        accept=lambda events: events.positions[2] < 0.43,
    )  # fmt: skip
    world.reset(np.random.default_rng(0))
    assert not world.happened().touched
    with pytest.raises(ArgumentError, match="control: expected auto or one of direct"):
        from_gymnasium(make_environment("Reacher-v5"), control="torque")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("FetchPsh-v4", "no Gymnasium environment 'FetchPsh-v4' .* did you mean FetchPush-v4"),
        ("Nothing-v0", "no Gymnasium environment 'Nothing-v0'"),
    ],
)
def test_unknown_environments_are_answered_with_near_names(name: str, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make_environment(name)


def test_sensors_of_the_world_move_by_contact_alone() -> None:
    world = from_gymnasium(make_environment("Pusher-v5"), sensors=["world"])
    assert "6 of 23 sensors are of the world" in world.choices  # the object, and the goal
    equal, other = np.zeros(6), np.array([0.05, 0, 0, 0, 0, 0])
    assert world.distance(equal, equal) == 0 and world.distance(equal, other) > 0.1
    fetch = from_gymnasium(make_environment("FetchReach-v4"), sensors=["world"], tries=1)
    assert any("sensors are of the world" in choice for choice in fetch.choices)
