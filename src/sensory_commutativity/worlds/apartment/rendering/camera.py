"""A camera: what a scene looks like from somewhere, and which thing each pixel shows. Needs no display, no GPU, no system library."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..scenes.scene import Part
from .raster import LIGHT, colour, rasterise, transform
from .textures import TEXTURES, texture


@dataclass(frozen=True)
class Camera:
    """How a camera sees.

    Attributes
    ----------
    width, height : int
        Pixels.
    field_of_view : float
        Vertical, degrees.
    supersampling : int
        Samples per pixel in each direction, of which a pixel is the mean: without, edges jump from pixel to pixel.
    near : float
        Metres: what is nearer is not seen.
    """

    width: int = 128
    height: int = 128
    field_of_view: float = 90.0
    supersampling: int = 3
    near: float = 0.05


@dataclass(frozen=True)
class Drawable:
    """Something visible that moves with a body; body 0 is the world and never moves."""

    part: Part
    identity: int
    body: int


class Picture(NamedTuple):
    """What a camera sees.

    Attributes
    ----------
    rgb : uint8 (h, w, 3)
    identity : int32 (h, w)
        That of the piece in the middle of each pixel, 0 for nothing.
    depth : float32 (h, w)
        Metres along the direction of view to what is there; infinite for nothing.
    """

    rgb: np.ndarray
    identity: np.ndarray
    depth: np.ndarray


class Renderer:
    """Draws the same drawables again and again.

    Parameters
    ----------
    drawables : sequence of Drawable
    n_bodies : int
        Bodies, the world among them.
    """

    def __init__(self, drawables: Sequence[Drawable], n_bodies: int):
        drawables = [piece for piece in drawables if len(piece.part.mesh.faces)]
        if any(not 0 <= piece.body < n_bodies for piece in drawables):
            raise ValueError(
                f"a piece is on a body that is not there; bodies are numbered from 0 to {n_bodies - 1}"
            )
        meshes = [piece.part.mesh for piece in drawables]
        face_ends = np.cumsum([len(mesh.faces) for mesh in meshes], dtype=np.int64)
        vertex_ends = np.cumsum([len(mesh.vertices) for mesh in meshes], dtype=np.int64)
        counts = [len(mesh.faces) for mesh in meshes]
        starts = vertex_ends - [len(mesh.vertices) for mesh in meshes]
        self.n_bodies, self.n_faces = n_bodies, int(face_ends[-1]) if drawables else 0
        self._pieces = np.stack(
            [
                face_ends - counts,
                face_ends,
                starts,
                vertex_ends,
                [piece.body for piece in drawables],
            ],
            1,
        ).astype(np.int64)
        self._balls = np.array([_ball(mesh.vertices) for mesh in meshes]).reshape(-1, 4)
        self._vertices = np.concatenate([np.zeros((0, 3)), *(mesh.vertices for mesh in meshes)])
        self._faces = np.concatenate(
            [
                np.zeros((0, 3), np.int32),
                *(mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)),
            ]
        ).astype(np.int32)
        self._uv = np.concatenate(
            [np.zeros((0, 3, 2), np.float32), *(mesh.uv for mesh in meshes)]
        ).astype(np.float32)
        self._colours = np.repeat(
            np.array([piece.part.colour for piece in drawables], np.float32).reshape(-1, 3),
            counts,
            axis=0,
        )
        self._texture_of = np.repeat(
            np.array([_texture_number(piece.part) for piece in drawables], np.int32), counts
        )
        self._identities = np.repeat(
            np.array([piece.identity for piece in drawables], np.int32), counts
        )
        self._textures = np.stack([texture(name) for name in TEXTURES])
        self._world = self._vertices.copy()
        self._found = (
            np.empty((self.n_faces, 9)),
            np.empty(self.n_faces),
            np.empty(self.n_faces, np.int64),
        )
        self._samples: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}

    def render(
        self,
        camera: Camera,
        eye_pose: np.ndarray,
        body_poses: np.ndarray,
        light: np.ndarray = LIGHT,
    ) -> Picture:
        """Draw a picture.

        Parameters
        ----------
        camera : Camera
        eye_pose : float64 (4, 4)
            Frame of the camera in the world: x is where it looks, y left, z up.
        body_poses : float64 (n_bodies, 4, 4)
            Frames of the bodies; the first is not looked at.
        light : float64 (3,)
            Direction to the light, of length 1.

        Returns
        -------
        Picture
            New arrays.
        """
        poses = np.ascontiguousarray(body_poses, np.float64)
        if poses.shape != (self.n_bodies, 4, 4):
            raise ValueError(
                f"body_poses has the shape {poses.shape}, but there are {self.n_bodies} bodies; give float64 ({self.n_bodies}, 4, 4)"
            )
        eye = np.ascontiguousarray(eye_pose, np.float64)
        s = camera.supersampling
        width, height = camera.width * s, camera.height * s
        if (height, width) not in self._samples:
            self._samples[height, width] = (
                np.empty((height, width), np.float32),
                np.empty((height, width), np.int32),
            )
        depth, index = self._samples[height, width]
        planes, shades, slots = self._found
        focal = height / 2 / math.tan(math.radians(camera.field_of_view) / 2)
        transform(self._pieces, self._vertices, poses, self._world)
        rasterise(
            self._pieces, self._balls, self._faces, self._world, self._uv, poses, eye, light, width, height, focal, camera.near,
            depth, index, planes, shades, slots,
        )  # fmt: skip
        rgb, identity = (
            np.empty((camera.height, camera.width, 3), np.uint8),
            np.empty((camera.height, camera.width), np.int32),
        )
        colour(
            index,
            planes,
            shades,
            slots,
            self._colours,
            self._texture_of,
            self._textures,
            self._identities,
            s,
            rgb,
            identity,
        )
        with np.errstate(divide="ignore"):
            return Picture(rgb, identity, 1 / depth[s // 2 :: s, s // 2 :: s])


def look_at(eye: Sequence[float], target: Sequence[float]) -> np.ndarray:
    """The frame of a camera at `eye` that looks at `target`, upright unless it looks straight up or down: float64 (4, 4)."""
    forward = np.subtract(target, eye).astype(np.float64)
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    left = np.cross(up, forward)
    left /= np.linalg.norm(left)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = (
        forward,
        left,
        np.cross(forward, left),
        eye,
    )
    return frame


def _texture_number(part: Part) -> int:
    if not part.texture:
        return -1
    if part.texture not in TEXTURES:
        raise ValueError(f"there is no texture {part.texture!r}; there are {', '.join(TEXTURES)}")
    return TEXTURES.index(part.texture)


def _ball(vertices: np.ndarray) -> tuple[float, float, float, float]:
    """Middle and radius of a ball around points."""
    middle = (vertices.min(0) + vertices.max(0)) / 2
    return *(float(c) for c in middle), float(np.linalg.norm(vertices - middle, axis=1).max())
