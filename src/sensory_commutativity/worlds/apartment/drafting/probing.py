"""Trials of a described robot in free space: does every degree of freedom do what it is told?

A joint that hardly moves, starts at its stop or touches the robot itself gets an SCP that says
nothing about the world. Here each degree of freedom is driven alone, on an endless empty floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....scp.experiment import REST_STEPS, compare_orders, orders_per_dof
from ....seeding import generator, seed_for
from ..physics.simulation import Simulation
from ..physics.starts import draw_start
from ..rendering.camera import Camera
from ..robots.robot import CONTROL_STEP, Robot
from ..scenes.empty import empty_floor
from ..world import ApartmentWorld

DRIVE_STEPS = 5
"""Actions of 1 with which a degree of freedom is driven. Chosen: half a second."""
HARDLY = 0.1
"""Share of the commanded motion below which a degree of freedom hardly moves. Chosen."""
SAME = 1e-3
"""rad or m by which two orders may end apart and still commute; chosen: a hundredth of what an
action moves. Rounding leaves 1e-6."""
CONTROL_SEQUENCE = 50
"""Actions of a sequence; as of the experiments in apartments."""


@dataclass(frozen=True)
class DofProbe:
    """What a degree of freedom did in free space.

    Attributes
    ----------
    name, unit, group : str
    asked, moved : float
        Commanded and measured motion, rad or m; of a wheel, the angle by which it rolled.
    at_stop : float
        Share of the starts from which an action could reach a stop.
    stopped : float
        Share of the experiments in which a stop ended a motion; NaN without experiments.
    touched : tuple of str
        What touched when it was driven alone: pairs of the robot's own links, or the floor.
    self_contact : float
        Share of the experiments that touched the robot itself or the floor; NaN without.
    commuted : float
        Share of the experiments whose two orders ended equal; NaN without.
    n : int
        Experiments.
    """

    name: str
    unit: str
    group: str
    asked: float
    moved: float
    at_stop: float
    stopped: float
    touched: tuple[str, ...]
    self_contact: float
    commuted: float
    n: int

    @property
    def problems(self) -> list[str]:
        """What makes its SCP say little about the world, in words."""
        found = []
        if self.asked and abs(self.moved) < HARDLY * abs(self.asked):
            found.append(
                f"hardly moves: {self.moved:.2g} of {self.asked:.2g} {self.unit}; check its "
                "inertia, force, or what it touches"
            )
        if self.at_stop > 0:
            found.append(f"starts at a stop in {self.at_stop:.0%}; set start away from its limits")
        if self.touched:
            found.append(f"touches {', '.join(self.touched)}")
        if self.n and self.commuted < 0.99:
            reasons = [
                text
                for share, text in ((self.stopped, "stops"), (self.self_contact, "own body"))
                if share > 0
            ]
            why = f" ({' and '.join(reasons)})" if reasons else ""
            found.append(f"commutes in {self.commuted:.0%} of {self.n} only{why}")
        return found


def probe_robot(robot: Robot, tries: int = 0, seed: int = 0) -> list[DofProbe]:
    """Drive each degree of freedom alone in free space.

    Parameters
    ----------
    robot : Robot
    tries : int
        SC-experiments of every degree of freedom in free space; 0 for none.
    seed : int
        Determines starts and sequences.

    Raises
    ------
    StartError
        Every start touches something; the message says which links.
    """
    world = ApartmentWorld(empty_floor("free-space"), robot, [Camera(32, 32, 90.0, 1)])
    rng = generator(seed, "probe")
    _require_starts(world.simulation, rng)
    driven = [_drive_alone(world.simulation, k, rng) for k in range(len(robot.dofs))]
    results = [_play(world, seed, i) for i in range(tries)]
    shares = np.array(results).reshape(tries, len(robot.dofs), 3).mean(0) if tries else None
    probes = []
    for k, (dof, settings) in enumerate(zip(robot.dofs, robot.description.dofs, strict=True)):
        asked, moved, touched = driven[k]
        commuted, stopped, contact = shares[k] if shares is not None else [math.nan] * 3
        probes.append(
            DofProbe(
                dof.name,
                dof.unit,
                settings.group,
                asked,
                moved,
                _share_at_stop(robot, k),
                float(stopped),
                touched,
                float(contact),
                float(commuted),
                tries,
            )
        )
    world.simulation.close()
    return probes


def _require_starts(simulation: Simulation, rng: np.random.Generator) -> None:
    """Fail early, and say why, if no start is free; drawing thousands takes long."""
    draw_start(simulation, rng, max_draws=500)


def _drive_alone(
    simulation: Simulation, k: int, rng: np.random.Generator
) -> tuple[float, float, tuple[str, ...]]:
    """Commanded and measured motion of a degree of freedom, and what touched."""
    draw_start(simulation, rng)
    robot, dof = simulation.robot, simulation.robot.dofs[k]
    start_joints, start_base = simulation.joints(), simulation.base()
    names = [joint.name for joint in robot.joints]
    settings = robot.description.dofs[k]
    joint = next((name for name in settings.joints if name in names), None)
    sign, asked = 1.0, DRIVE_STEPS * dof.speed
    if joint is not None:
        i, ratio = names.index(joint), robot.ratio_of_joint[joint]
        low, high = sorted((robot.limits[i] - start_joints[i]) / ratio)
        sign = 1.0 if high >= -low else -1.0
        asked = min(asked, max(high, -low))
    action = np.zeros(len(robot.dofs))
    action[k] = sign
    touched: set[str] = set()
    for step in range(DRIVE_STEPS + REST_STEPS):
        simulation.step(action if step < DRIVE_STEPS else np.zeros(len(robot.dofs)))
        touched |= {
            f"{a} - {b if kind == 'link' else kind}"
            for a, kind, b in simulation.collisions.penetrating_pairs()
        }
    if joint is not None:
        moved = sign * (simulation.joints()[i] - start_joints[i]) / ratio
    else:  # a wheel: the robot turns about the other one
        turned = simulation.base()[2] - start_base[2]
        side = 1.0 if settings.joints[0] == robot.wheels[0] else -1.0
        moved = side * turned * robot.track / robot.wheel_radius
    return asked, float(moved), tuple(sorted(touched))


def _share_at_stop(robot: Robot, k: int) -> float:
    """Share of the start range from which one action reaches a stop."""
    shares = [0.0]
    settings = robot.description.dofs[k]
    for joint, (low, high), (lower, upper) in zip(
        robot.joints, robot.start_ranges, robot.limits, strict=True
    ):
        if joint.name not in settings.joints or joint.name in robot.followers:
            continue
        reach = settings.velocity * CONTROL_STEP * abs(robot.ratio_of_joint[joint.name])
        if high > low:
            near = max(0.0, lower + reach - low) + max(0.0, high - (upper - reach))
            shares.append(min(near / (high - low), 1.0))
        else:
            shares.append(float(low < lower + reach - 1e-9 or low > upper - reach + 1e-9))
    return max(shares)


def _play(world: ApartmentWorld, seed: int, i: int) -> list[tuple[float, float, float]]:
    """One experiment per degree of freedom: did it commute, was it stopped, did it touch itself."""
    own = seed_for(seed, "probe", i)
    world.reset(generator(own, "situation"))
    start = world.snapshot()
    rows = []
    for _, sequence, permuted in orders_per_dof(world, own, CONTROL_SEQUENCE, start):
        endings = compare_orders(world, start, sequence, permuted, REST_STEPS, world.happened)
        first, second = endings.first, endings.second
        apart = np.abs(np.concatenate([first.base - second.base, first.joints - second.joints]))
        stopped = first.at_limit + second.at_limit > 0
        contact = sum(ending.touched_self + ending.touched_fixed for ending in (first, second)) > 0
        rows.append((float(apart.max(initial=0.0) <= SAME), float(stopped), float(contact)))
    return rows
