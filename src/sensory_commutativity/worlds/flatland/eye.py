"""The eye: a compiled ray caster that renders a flat world as a line of RGB pixels.

There is one ray per pixel, at equal angles. A pixel has the colour of the first surface that its
ray hits, without shading (as in the authors' simulator), or is black if the ray hits nothing. All
geometry is first transformed to the frame of the eye: the view depends on relative poses only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled import njit


def ray_directions(pixels: int, field_of_view: float) -> np.ndarray:
    """Unit vectors of the rays in the eye's frame (x ahead, y left), from right to left.

    Parameters
    ----------
    pixels : int
    field_of_view : float
        In rad.

    Returns
    -------
    float64 (pixels, 2)
    """
    angles = field_of_view * ((np.arange(pixels) + 0.5) / pixels - 0.5)
    return np.stack([np.cos(angles), np.sin(angles)], 1)


class Scene(NamedTuple):
    """What the eye can see, except poses: `n` objects (with arms and floor zones) and `m` walls."""

    rays: np.ndarray  # float64 (pixels, 2), from ray_directions
    field_of_view: float  # rad
    view_range: float  # units
    outlines: np.ndarray  # float64 (n, vertices, 2): in their own frames, counter-clockwise
    vertices: np.ndarray  # int64 (n,): number of vertices; 0 for a disc
    radius: np.ndarray  # float64 (n,), units: of the disc, or of the polygon's enclosing circle
    colour: np.ndarray  # uint8 (n, 3)
    walls: np.ndarray  # float64 (m, 4): x1, y1, x2, y2; the first end is left as seen from inside
    wall_colour: np.ndarray  # uint8 (m, 3)


@njit()
def render(scene, eye, eyelid, poses, out):
    """Render the view.

    Parameters
    ----------
    scene : Scene
    eye : tuple of float
        x, y, heading; units, rad.
    eyelid : float in [0, 2]
        Colours are multiplied by it and clipped to 255.
    poses : float64 (n, 3)
        x, y, angle of each object; units, rad.
    out : uint8 (pixels, 3)
        Is written: RGB from right to left.
    """
    pixels = scene.rays.shape[0]
    depth = np.full(pixels, scene.view_range)
    hit = np.full(pixels, -1)  # index of the nearest surface: objects first, then walls
    _cast_walls(scene, eye, depth, hit)
    _cast_objects(scene, eye, poses, depth, hit)
    _colour_pixels(scene, eyelid, hit, out)


@njit()
def _cast_walls(scene, eye, depth, hit):
    x, y, heading = eye
    cos, sin = math.cos(heading), math.sin(heading)
    walls, pixels = scene.walls, scene.rays.shape[0]
    for i in range(walls.shape[0]):
        ax, ay = _rotate_back(walls[i, 0] - x, walls[i, 1] - y, cos, sin)
        bx, by = _rotate_back(walls[i, 2] - x, walls[i, 3] - y, cos, sin)
        index = len(scene.vertices) + i
        _cast_segment(scene.rays, scene.field_of_view, 0, pixels, ax, ay, bx, by, index, depth, hit)


@njit()
def _cast_objects(scene, eye, poses, depth, hit):
    x, y, heading = eye
    cos, sin = math.cos(heading), math.sin(heading)
    rays, field_of_view, view_range = scene.rays, scene.field_of_view, scene.view_range
    outlines, vertices, radius = scene.outlines, scene.vertices, scene.radius
    corner = np.empty((outlines.shape[1], 2))
    for i in range(len(vertices)):
        cx, cy = _rotate_back(poses[i, 0] - x, poses[i, 1] - y, cos, sin)
        first, last = _pixels_covered(cx, cy, radius[i], len(rays), field_of_view, view_range)
        if first >= last:
            continue
        if vertices[i] == 0:
            _cast_disc(rays, first, last, cx, cy, radius[i], i, depth, hit)
            continue
        turn = poses[i, 2] - heading
        turn_cos, turn_sin = math.cos(turn), math.sin(turn)
        for k in range(vertices[i]):
            corner[k, 0] = cx + turn_cos * outlines[i, k, 0] - turn_sin * outlines[i, k, 1]
            corner[k, 1] = cy + turn_sin * outlines[i, k, 0] + turn_cos * outlines[i, k, 1]
        for k in range(vertices[i]):
            ax, ay = corner[k, 0], corner[k, 1]
            following = (k + 1) % vertices[i]
            bx, by = corner[following, 0], corner[following, 1]
            _cast_segment(rays, field_of_view, first, last, ax, ay, bx, by, i, depth, hit)


@njit()
def _colour_pixels(scene, eyelid, hit, out):
    """Write the colour of the surface that each ray hit, as seen through the eyelid."""
    n_objects, n_walls = len(scene.vertices), scene.walls.shape[0]
    shown = np.empty((n_objects + n_walls, 3), np.uint8)
    for i in range(n_objects + n_walls):
        for channel in range(3):
            if i < n_objects:
                value = scene.colour[i, channel]
            else:
                value = scene.wall_colour[i - n_objects, channel]
            shown[i, channel] = np.uint8(min(255.0, value * eyelid + 0.5))
    for j in range(len(hit)):
        for channel in range(3):
            out[j, channel] = 0 if hit[j] < 0 else shown[hit[j], channel]


@njit()
def _rotate_back(x, y, cos, sin):
    """Rotate (x, y) by minus the angle whose cosine and sine are given."""
    return x * cos + y * sin, y * cos - x * sin


@njit()
def _pixels_covered(cx, cy, radius, pixels, field_of_view, view_range):
    """Half-open range of pixels whose rays may hit the disc; empty if it is out of sight."""
    distance = math.hypot(cx, cy)
    if distance - radius > view_range:
        return 0, 0
    if distance <= radius or field_of_view > math.pi:
        return 0, pixels
    middle, half = math.atan2(cy, cx), math.asin(radius / distance)
    return _pixels_between(middle - half, middle + half, pixels, field_of_view)


@njit()
def _pixels_between(low, high, pixels, field_of_view):
    """Half-open range of pixels between two directions, rad, widened by a pixel for rounding."""
    step = field_of_view / pixels
    first = math.floor((low + field_of_view / 2) / step - 0.5)
    last = math.ceil((high + field_of_view / 2) / step - 0.5) + 1
    return max(0, first), min(pixels, last)


@njit()
def _cast_disc(rays, first, last, cx, cy, radius, index, depth, hit):
    """Intersect a disc with the rays `first` to `last`; the inside of a disc is invisible."""
    outside = cx * cx + cy * cy - radius * radius
    for j in range(first, last):
        along = cx * rays[j, 0] + cy * rays[j, 1]
        discriminant = along * along - outside
        if discriminant >= 0:
            t = along - math.sqrt(discriminant)
            if 0 <= t < depth[j]:
                depth[j], hit[j] = t, index


@njit()
def _cast_segment(rays, field_of_view, first, last, ax, ay, bx, by, index, depth, hit):
    """Intersect the segment from a to b with rays; it is visible only with a on the left."""
    ex, ey = bx - ax, by - ay
    cross = ay * ex - ax * ey
    if cross <= 0:
        return
    if last - first > 8:  # otherwise two arc tangents cost more than they save
        left, right = math.atan2(ay, ax), math.atan2(by, bx)
        if left >= right:  # otherwise the segment crosses the direction straight behind
            low, high = _pixels_between(right, left, len(rays), field_of_view)
            first, last = max(first, low), min(last, high)
    for j in range(first, last):
        rx, ry = rays[j, 0], rays[j, 1]
        denominator = ry * ex - rx * ey
        if denominator > 0:
            along = ay * rx - ax * ry
            if 0 <= along <= denominator and cross < depth[j] * denominator:
                depth[j], hit[j] = cross / denominator, index
