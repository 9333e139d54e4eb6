"""A software renderer: colour, segmentation and depth images of a scene.

It needs no display, no GPU and no system library.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..scenes.scene import Part
from .raster import (
    LIGHT,
    Samples,
    Surfaces,
    Triangles,
    View,
    VisibleFaces,
    rasterise,
    shade_pixels,
    transform_vertices,
)
from .textures import TEXTURES, make_texture


@dataclass(frozen=True)
class Camera:
    """Intrinsics of a pinhole camera.

    Attributes
    ----------
    width, height : int
        Pixels.
    field_of_view : float
        Vertical, degrees.
    supersampling : int
        Samples per pixel in each direction. A pixel is their mean; without it edges move in steps
        of whole pixels.
    near : float
        Distance of the near plane, metres; chosen: small compared with any room.
    """

    width: int = 128
    height: int = 128
    field_of_view: float = 90.0
    supersampling: int = 3
    near: float = 0.05


@dataclass(frozen=True)
class Drawable:
    """A visible part that moves with a body.

    Attributes
    ----------
    part : Part
    segmentation_id : int
        Value of its pixels in segmentation images.
    body : int
        Index of the body. Body 0 is the world and never moves.
    """

    part: Part
    segmentation_id: int
    body: int


class Picture(NamedTuple):
    """A rendered view.

    Attributes
    ----------
    rgb : uint8 (h, w, 3)
    segmentation : int32 (h, w)
        Segmentation id of the drawable at the centre of each pixel; 0 is background.
    depth : float32 (h, w)
        Metres along the optical axis; infinite for background.
    """

    rgb: np.ndarray
    segmentation: np.ndarray
    depth: np.ndarray


class Renderer:
    """Renders a fixed set of drawables.

    Parameters
    ----------
    drawables : sequence of Drawable
    n_bodies : int
        Number of bodies, including the world.

    Raises
    ------
    ValueError
        A body index is out of range, or a texture is unknown.
    """

    def __init__(self, drawables: Sequence[Drawable], n_bodies: int):
        drawables = [drawable for drawable in drawables if len(drawable.part.mesh.faces)]
        if any(not 0 <= drawable.body < n_bodies for drawable in drawables):
            raise ValueError(
                "a drawable is on a body that is not there; "
                f"bodies are numbered from 0 to {n_bodies - 1}"
            )
        self.n_bodies = n_bodies
        self._triangles = _gather_triangles(drawables)
        self._surfaces = _gather_surfaces(drawables)
        self._world = self._triangles.vertices.copy()  # vertices of body 0 stay as they are
        n_faces = len(self._triangles.faces)
        self._visible = VisibleFaces(
            np.empty((n_faces, 9)), np.empty(n_faces), np.empty(n_faces, np.int64)
        )
        self._samples: dict[tuple[int, int], Samples] = {}  # buffers by (height, width)

    def render(
        self,
        camera: Camera,
        camera_pose: np.ndarray,
        body_poses: np.ndarray,
        light: np.ndarray = LIGHT,
    ) -> Picture:
        """Render a view.

        Parameters
        ----------
        camera : Camera
        camera_pose : float64 (4, 4)
            Camera frame in the world: x forward, y left, z up.
        body_poses : float64 (n_bodies, 4, 4)
            Frames of the bodies in the world. The first is ignored.
        light : float64 (3,)
            Unit vector towards the light in the world frame.

        Returns
        -------
        Picture
            New arrays.

        Raises
        ------
        ValueError
            `body_poses` has the wrong shape.
        """
        poses = np.ascontiguousarray(body_poses, np.float64)
        if poses.shape != (self.n_bodies, 4, 4):
            raise ValueError(
                f"body_poses has the shape {poses.shape}, but there are {self.n_bodies} bodies; "
                f"give float64 ({self.n_bodies}, 4, 4)"
            )
        pose = np.ascontiguousarray(camera_pose, np.float64)
        s = camera.supersampling
        width, height = camera.width * s, camera.height * s
        if (height, width) not in self._samples:
            self._samples[height, width] = Samples(
                np.empty((height, width), np.float32), np.empty((height, width), np.int32)
            )
        samples = self._samples[height, width]
        focal = height / 2 / math.tan(math.radians(camera.field_of_view) / 2)
        view = View(pose, width, height, focal, camera.near)
        transform_vertices(self._triangles, poses, self._world)
        rasterise(self._triangles, self._world, poses, light, view, samples, self._visible)
        rgb = np.empty((camera.height, camera.width, 3), np.uint8)
        segmentation = np.empty((camera.height, camera.width), np.int32)
        shade_pixels(self._surfaces, samples, self._visible, s, rgb, segmentation)
        with np.errstate(divide="ignore"):
            depth = 1 / samples.inverse_depth[s // 2 :: s, s // 2 :: s]
        return Picture(rgb, segmentation, depth)


def look_at(eye: Sequence[float], target: Sequence[float]) -> np.ndarray:
    """Return the frame of a camera at `eye` that looks at `target`: float64 (4, 4).

    It is upright, except that a camera that looks straight up or down has its up axis in the
    x-y plane.
    """
    forward = np.subtract(target, eye).astype(np.float64)
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    left = np.cross(up, forward)
    left /= np.linalg.norm(left)
    frame = np.eye(4)
    frame[:3, 0] = forward
    frame[:3, 1] = left
    frame[:3, 2] = np.cross(forward, left)
    frame[:3, 3] = eye
    return frame


def _gather_triangles(drawables: Sequence[Drawable]) -> Triangles:
    meshes = [drawable.part.mesh for drawable in drawables]
    n_faces = [len(mesh.faces) for mesh in meshes]
    n_vertices = [len(mesh.vertices) for mesh in meshes]
    face_ends = np.cumsum(n_faces, dtype=np.int64)
    vertex_ends = np.cumsum(n_vertices, dtype=np.int64)
    vertex_starts = vertex_ends - n_vertices
    bodies = [drawable.body for drawable in drawables]
    sides = [1 + drawable.part.two_sided for drawable in drawables]
    table = np.stack([face_ends - n_faces, face_ends, vertex_starts, vertex_ends, bodies, sides], 1)
    spheres = [_bounding_sphere(mesh.vertices) for mesh in meshes]
    # The empty arrays give the right shape where there is nothing to draw.
    vertices = [np.zeros((0, 3)), *(mesh.vertices for mesh in meshes)]
    faces = [mesh.faces + start for mesh, start in zip(meshes, vertex_starts, strict=True)]
    uv = [np.zeros((0, 3, 2), np.float32), *(mesh.uv for mesh in meshes)]
    return Triangles(
        table.astype(np.int64),
        np.array(spheres).reshape(-1, 4),
        np.concatenate(vertices),
        np.concatenate([np.zeros((0, 3), np.int32), *faces]).astype(np.int32),
        np.concatenate(uv).astype(np.float32),
    )


def _gather_surfaces(drawables: Sequence[Drawable]) -> Surfaces:
    n_faces = [len(drawable.part.mesh.faces) for drawable in drawables]
    colours = np.array([drawable.part.colour for drawable in drawables], np.float32)
    texture_ids = np.array([_texture_id(drawable.part) for drawable in drawables], np.int32)
    segmentation_ids = np.array([drawable.segmentation_id for drawable in drawables], np.int32)
    return Surfaces(
        np.repeat(colours.reshape(-1, 3), n_faces, axis=0),
        np.repeat(texture_ids, n_faces),
        np.stack([make_texture(name) for name in TEXTURES]),
        np.repeat(segmentation_ids, n_faces),
    )


def _texture_id(part: Part) -> int:
    if not part.texture:
        return -1
    if part.texture not in TEXTURES:
        raise ValueError(f"there is no texture {part.texture!r}; there are {', '.join(TEXTURES)}")
    return TEXTURES.index(part.texture)


def _bounding_sphere(vertices: np.ndarray) -> tuple[float, float, float, float]:
    """Centre and radius of a sphere around points."""
    centre = (vertices.min(0) + vertices.max(0)) / 2
    x, y, z = (float(c) for c in centre)
    return x, y, z, float(np.linalg.norm(vertices - centre, axis=1).max())
