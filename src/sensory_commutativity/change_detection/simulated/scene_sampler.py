"""An apartment full of things: where pairs of pictures are made, and where SC-experiments on objects are played (paper, section IV-A).

A household is one apartment, one robot and a set of objects of one family. Objects are scattered over floor and furniture again and again, and
the robot begins somewhere among them, its arm in any pose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...worlds.apartment import frames as fr
from ...worlds.apartment.geometry import scaled
from ...worlds.apartment.physics.simulation import PARKED
from ...worlds.apartment.physics.starts import arm_links, draw_place
from ...worlds.apartment.rendering.camera import Camera, Picture, Renderer
from ...worlds.apartment.rendering.raster import LIGHT
from ...worlds.apartment.rendering.textures import TEXTURES
from ...worlds.apartment.robots.robot import Robot
from ...worlds.apartment.scenes.objects import OBJECTS, Family, of_family
from ...worlds.apartment.scenes.scene import Movable, Part, Scene
from ...worlds.apartment.world import ApartmentWorld, drawables

TRIES = 60
"""How often something random is drawn before another situation is tried."""
RESTING = 600
"""Substeps (2.5 s) in which scattered objects come to rest and fall asleep."""
NEAR_TRIES = 300
"""How often a situation beside an object is drawn; chosen: about one in ten is free."""
BESIDE = (0.4, 0.15)
"""Metres from the hand to that object, in the plane and in height; chosen: as far as a hand comes in a second."""
LYING = 0.2
"""Of the scattered objects, those laid on their side; chosen: as what arms have pushed over."""
RECOLOURED = 0.6
"""Of the scenes to learn from, those whose rooms, furniture and objects have other colours; chosen: one apartment has to stand for all."""
OWN = 0.5
"""Of the objects to learn from, those with their own size and, in scenes that are not recoloured, their own colours; chosen: as met in tests."""
_AWAY = 40.0  # metres: where objects are that found no place


class View(NamedTuple):
    """What is seen at one moment, and from where: pictures, one per camera; float64 (4, 4), the frame of the camera."""

    pictures: tuple[Picture, ...]
    eye: np.ndarray


class SceneSampler:
    """An apartment, a robot and objects.

    Parameters
    ----------
    scene : Scene
        Its own movable objects are replaced.
    robot : Robot
    cameras : sequence of Camera
        All sit where the robot's camera is.
    family : str
        Which objects: ``training`` or ``testing``.
    rng : numpy.random.Generator
        All that is random follows from it.
    objects : int
        How many there are.
    varied : bool
        Whether half of the objects have other sizes and colours than their own, and all has other colours in most scenes: to learn from. To test on,
        things are as they are.

    Attributes
    ----------
    world : ApartmentWorld
    simulation : Simulation
    scattered : float64 (objects, 7)
        Where the objects lie while nothing disturbs them.
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        cameras: Sequence[Camera],
        family: Family,
        rng: np.random.Generator,
        objects: int = 40,
        varied: bool = True,
    ):
        self.rng, self.cameras, self.varied = rng, tuple(cameras), varied
        self.scene = replace(
            scene, movables=tuple(_random_object(family, i, rng, varied) for i in range(objects))
        )
        self.world = ApartmentWorld(self.scene, robot, cameras)
        self.simulation = self.world.simulation
        self.scattered = self.simulation.object_poses()
        self._bodies = 1 + objects + len(self.simulation.body.parents)
        self._renderer = self.world.renderer

    def scatter(self) -> None:
        """New places for all objects, and new colours."""
        simulation, rng, movables = self.simulation, self.rng, self.scene.movables
        simulation.place(np.array(PARKED), simulation.robot.start_ranges.mean(1))
        for i in range(len(movables)):
            self.put_away(i)
        for i in range(len(movables)):
            for _ in range(TRIES):
                area = self.scene.areas[int(rng.integers(len(self.scene.areas)))]
                lying = rng.uniform() < LYING
                if self.stand(
                    i,
                    rng.uniform(*area.x),
                    rng.uniform(*area.y),
                    float(rng.choice([2.2, 1.15])),
                    lying,
                ):  # under shelves and tables, too
                    break
            else:
                self.put_away(i)
        simulation.wait(RESTING)
        simulation.keep_objects()
        self.scattered = simulation.object_poses()
        if self.varied:
            self._renderer = self._painted_renderer()

    def stand(
        self,
        i: int,
        x: float,
        y: float,
        from_height: float,
        lying: bool = False,
        heading: float | None = None,
    ) -> bool:
        """Stand the i-th object on what is below a point, or lay it on its side, turned by `heading` (rad) or anyhow; False, with the object away, if
        there is no room."""
        self.put_away(i)  # or it would stand on itself
        surface = self.simulation.surface_below(x, y, from_height)
        if surface is None:
            return False
        movable, turn = (
            self.scene.movables[i],
            self.rng.uniform(-math.pi, math.pi) if heading is None else heading,
        )
        frame = fr.on_floor(
            x, y, turn, surface + (_radius(movable) if lying else _half_height(movable)) + 0.002
        )
        if lying:
            frame = frame @ fr.turned(np.array([1.0, 0.0, 0.0]), math.pi / 2)
        self.simulation.put_object(i, np.array([*frame[:3, 3], *fr.to_quaternion(frame)]))
        if self.simulation.object_penetrates(i):
            self.put_away(i)
            return False
        return True

    def put_away(self, i: int) -> None:
        """Take the i-th object out of the apartment."""
        self.simulation.put_object(
            i,
            np.array(
                [_AWAY + i, _AWAY, _half_height(self.scene.movables[i]) + 0.002, 0, 0, 0, 1.0]
            ),
        )

    def begin(self) -> None:
        """The robot somewhere among the scattered objects, its arm as it starts experiments or, in half of the cases, anyhow."""
        simulation, rng = self.simulation, self.rng
        draw_place(simulation, rng)
        if rng.uniform() < 0.5:
            base, joints = simulation.base(), simulation.joints()
            spread = np.minimum(1.0, np.diff(simulation.robot.limits)[:, 0] / 6)
            for _ in range(TRIES):
                if simulation.fits(
                    base,
                    np.clip(
                        joints + rng.normal(0, 0.6, len(joints)) * spread,
                        *simulation.robot.limits.T,
                    ),
                ):
                    break
            else:
                simulation.put_robot(base, joints)

    def begin_near_an_object(self) -> bool:
        """The robot with its hand beside an object, which it thus looks at; False if no such situation is found."""
        simulation, rng, robot = self.simulation, self.rng, self.simulation.robot
        simulation.place(np.array(PARKED), robot.start_ranges.mean(1))
        hand, spread = arm_links(simulation)[-1], np.minimum(1.0, np.diff(robot.limits)[:, 0] / 6)
        for _ in range(NEAR_TRIES):
            joints = np.clip(
                robot.draw_joints(rng) + rng.normal(0, 0.6, len(robot.joints)) * spread,
                *robot.limits.T,
            )
            ahead, left, height = simulation.body.link_poses(np.zeros(3), joints)[hand, :3, 3]
            things = self.scattered[np.abs(self.scattered[:, 2] - height) < BESIDE[1], :2]
            if not len(things):
                continue
            heading, apart, way = (
                rng.uniform(-math.pi, math.pi),
                BESIDE[0] * math.sqrt(rng.uniform()),
                rng.uniform(-math.pi, math.pi),
            )
            x, y = things[int(rng.integers(len(things)))] + apart * np.array(
                [math.cos(way), math.sin(way)]
            )
            x -= ahead * math.cos(heading) - left * math.sin(heading)
            y -= ahead * math.sin(heading) + left * math.cos(heading)
            if not any(
                area.x[0] < x < area.x[1] and area.y[0] < y < area.y[1] for area in self.scene.areas
            ):
                continue
            if simulation.fits(np.array([x, y, heading]), joints):
                return True
        return False

    def hand(self) -> np.ndarray:
        """Where the robot's hand is: float64 (3,), metres."""
        simulation = self.simulation
        return simulation.body.link_poses(simulation.base(), simulation.joints())[
            arm_links(simulation)[-1], :3, 3
        ]

    def look(self, eye: np.ndarray | None = None, light: np.ndarray = LIGHT) -> View:
        """What the robot sees, or would see from another place of its camera, float64 (4, 4), in another light."""
        eye = self.simulation.eye_pose() if eye is None else eye
        poses = self.simulation.poses()
        return View(
            tuple(self._renderer.render(camera, eye, poses, light) for camera in self.cameras), eye
        )

    def _painted_renderer(self) -> Renderer:
        scene = _recoloured(self.scene, self.rng) if self.rng.uniform() < RECOLOURED else self.scene
        shown = drawables(self.simulation)
        parts = [part for fixture in scene.fixtures for part in fixture.parts] + [
            part for movable in scene.movables for part in movable.parts
        ]
        return Renderer(
            [replace(piece, part=part) for piece, part in zip(shown, parts, strict=False)]
            + shown[len(parts) :],
            self._bodies,
        )


def displaced(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Which objects are not where they were, within a centimetre and five degrees: numbers, int (k,); of poses float64 (n, 7)."""
    shift = np.linalg.norm(before[:, :3] - after[:, :3], axis=1)
    turn = 2 * np.arccos(np.clip(np.abs((before[:, 3:] * after[:, 3:]).sum(1)), 0, 1))
    return np.nonzero((shift >= 0.01) | (turn >= math.radians(5)))[0]


def _radius(movable: Movable) -> float:
    """Metres from an object's upright axis to its furthest point."""
    return max(float(np.hypot(*part.mesh.vertices[:, :2].T).max()) for part in movable.parts)


def _half_height(movable: Movable) -> float:
    """Metres from an object's middle to where it stands."""
    return -float(min(part.mesh.vertices[:, 2].min() for part in movable.parts))


def _random_object(family: Family, i: int, rng: np.random.Generator, varied: bool) -> Movable:
    """An object of the family; varied: unless it keeps its OWN looks, of another size and in other colours."""
    what = OBJECTS[str(rng.choice(of_family(family)))]
    place = (_AWAY + i, _AWAY, 0.5)
    if not varied or rng.uniform() < OWN:
        return Movable(f"object-{i}", what.category, what.mass, what.parts, what.solids, place)
    factors = rng.uniform(0.75, 1.3) * rng.uniform(0.85, 1.18, 3)
    factors[1] = factors[0]  # round things stay round
    if any(solid.kind == "sphere" for solid in what.solids):
        factors[2] = factors[0]
    parts = tuple(
        _painted(replace(part, mesh=scaled(part.mesh, factors)), rng) for part in what.parts
    )
    solids = tuple(
        replace(
            solid,
            size=_scaled_size(solid.kind, solid.size, factors),
            position=tuple(float(p * f) for p, f in zip(solid.position, factors, strict=True)),
            vertices=None if solid.vertices is None else solid.vertices * factors,
        )
        for solid in what.solids
    )
    return Movable(
        f"object-{i}", what.category, what.mass * float(factors.prod()), parts, solids, place
    )


def _scaled_size(kind: str, size: tuple[float, ...], factors: np.ndarray) -> tuple[float, ...]:
    if kind == "box":
        return tuple(float(s * f) for s, f in zip(size, factors, strict=True))
    if kind == "cylinder":
        return float(size[0] * factors[0]), float(size[1] * factors[2])
    return tuple(float(s * factors[0]) for s in size)


def _painted(part: Part, rng: np.random.Generator) -> Part:
    texture = part.texture
    if rng.uniform() < 0.4:
        texture = "" if rng.uniform() < 0.4 else str(rng.choice(TEXTURES))
    return replace(part, colour=tuple(float(c) for c in rng.uniform(0.1, 1.0, 3)), texture=texture)  # type: ignore[arg-type]


def _recoloured(scene: Scene, rng: np.random.Generator) -> Scene:
    """The same rooms and things in other colours."""

    def other(part: Part) -> Part:
        if rng.uniform() > 0.6:
            return part
        colour = np.clip(
            np.array(part.colour) * rng.uniform(0.5, 1.3, 3) + rng.uniform(-0.2, 0.2, 3), 0.05, 1
        )
        texture = str(rng.choice(TEXTURES)) if rng.uniform() < 0.3 else part.texture
        return replace(part, colour=tuple(float(c) for c in colour), texture=texture)  # type: ignore[arg-type]

    fixtures = tuple(
        replace(fixture, parts=tuple(other(part) for part in fixture.parts))
        for fixture in scene.fixtures
    )
    movables = tuple(
        replace(movable, parts=tuple(_painted(part, rng) for part in movable.parts))
        for movable in scene.movables
    )
    return replace(scene, fixtures=fixtures, movables=movables)
