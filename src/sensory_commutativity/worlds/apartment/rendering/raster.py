"""Triangle rasterisation on the CPU, as compiled loops over visible faces and image samples.

Every front face gets a matrix that maps a viewing direction to its three homogeneous barycentric
coordinates (Olano and Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates",
https://doi.org/10.1145/258694.258723). The face covers the samples where all three are positive,
their sum is the inverse depth, and no face has to be clipped at the near plane. A first pass finds
the nearest face at each sample, a second one shades every pixel. All arithmetic is sequential, so
the same scene always gives bit-identical images.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....compiled import njit
from .textures import TEXTURE_SIZE

AMBIENT = 0.45
"""Brightness of a face that is turned away from the light; chosen by eye to look like a room."""
LIGHT = np.array([0.35, 0.5, 0.79]) / math.sqrt(0.35**2 + 0.5**2 + 0.79**2)
"""Unit vector towards the light in the world frame; chosen: the walls of a room differ."""
BACKGROUND = (0.72, 0.80, 0.90)
"""Colour where there is no face; chosen: sky blue."""
_TOLERANCE = 1e-9
"""Samples this little outside a face still belong to it. Otherwise rounding would leave gaps
between adjacent faces. Chosen: far below the size of a pixel."""


class Triangles(NamedTuple):
    """All triangles of the drawables, in the frames of their bodies.

    Attributes
    ----------
    drawables : int64 (d, 6)
        First face, end of faces, first vertex, end of vertices, body and number of visible sides of
        each drawable.
    spheres : float64 (d, 4)
        Centre and radius of a bounding sphere of each drawable.
    vertices : float64 (v, 3)
    faces : int32 (f, 3)
    uv : float32 (f, 3, 2)
    """

    drawables: np.ndarray
    spheres: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray


class Surfaces(NamedTuple):
    """Appearance of the faces.

    Attributes
    ----------
    colours : float32 (f, 3)
        Red, green, blue in [0, 1].
    texture_ids : int32 (f,)
        Index into `textures`, or -1.
    textures : uint8 (t, TEXTURE_SIZE, TEXTURE_SIZE, 3)
    segmentation_ids : int32 (f,)
    """

    colours: np.ndarray
    texture_ids: np.ndarray
    textures: np.ndarray
    segmentation_ids: np.ndarray


class View(NamedTuple):
    """A pinhole camera.

    Attributes
    ----------
    pose : float64 (4, 4)
        Camera frame in the world: x forward, y left, z up.
    width, height : int
        Image size in samples.
    focal : float
        Focal length in samples.
    near : float
        Distance of the near plane, metres.
    """

    pose: np.ndarray
    width: int
    height: int
    focal: float
    near: float


class Samples(NamedTuple):
    """Output of the first pass per sample.

    Attributes
    ----------
    inverse_depth : float32 (height, width)
        1 / metres along the optical axis; 0 where there is no face.
    slots : int32 (height, width)
        Index into :class:`VisibleFaces`; -1 where there is no face.
    """

    inverse_depth: np.ndarray
    slots: np.ndarray


class VisibleFaces(NamedTuple):
    """Output of the first pass per visible face; the arrays have room for all faces.

    Attributes
    ----------
    planes : float64 (f, 9)
        Coefficients (a, b, c) of a x + b y + c in sample coordinates for the inverse depth and for
        both texture coordinates times the inverse depth.
    shades : float64 (f,)
        Brightness in [AMBIENT, 1].
    face_ids : int64 (f,)
        Index of the face.
    """

    planes: np.ndarray
    shades: np.ndarray
    face_ids: np.ndarray


@njit()
def transform_vertices(triangles, poses, world):
    """Write the world coordinates of all vertices that move into `world`, float64 (v, 3).

    `poses` are the frames of the bodies, float64 (b, 4, 4). Body 0 is the world itself.
    """
    drawables, vertices = triangles.drawables, triangles.vertices
    for d in range(len(drawables)):
        body = drawables[d, 4]
        if body == 0:
            continue
        pose = poses[body]
        for i in range(drawables[d, 2], drawables[d, 3]):
            x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
            for k in range(3):
                world[i, k] = pose[k, 0] * x + pose[k, 1] * y + pose[k, 2] * z + pose[k, 3]


@njit()
def rasterise(triangles, world, poses, light, view, samples, visible):
    """Find the nearest face at every sample: the first pass.

    Parameters
    ----------
    triangles : Triangles
    world : float64 (v, 3)
        World coordinates of the vertices.
    poses : float64 (b, 4, 4)
        Frames of the bodies.
    light : float64 (3,)
        Unit vector towards the light.
    view : View
    samples, visible : Samples, VisibleFaces
        Filled.
    """
    # Numba counts references at each read of a tuple's field, so the loops read none.
    drawables, spheres = triangles.drawables, triangles.spheres
    faces, uv = triangles.faces, triangles.uv
    eye, focal, near = view.pose, view.focal, view.near
    half_x, half_y = view.width / 2, view.height / 2
    inverse_depth, slots = samples.inverse_depth, samples.slots
    planes, shades, face_ids = visible.planes, visible.shades, visible.face_ids
    inverse_depth[:] = 0.0
    slots[:] = -1
    corners, normal = np.empty((3, 3)), np.empty(3)
    count = 0
    for d in range(len(drawables)):
        pose = poses[drawables[d, 4]]
        if _is_out_of_view(spheres[d], pose, eye, half_x, half_y, focal, near):
            continue
        sides = drawables[d, 5]
        for face in range(drawables[d, 0], drawables[d, 1]):
            n_behind = _to_camera(faces, face, sides, world, eye, near, corners, normal)
            if n_behind == 3:
                continue
            bounds = _sample_bounds(corners, n_behind, half_x, half_y, focal, near)
            if bounds[0] > bounds[1] or bounds[2] > bounds[3]:
                continue
            if _fill(
                corners, uv[face], half_x, half_y, focal, near, bounds, inverse_depth, slots,
                planes[count], count,
            ):  # fmt: skip
                nx, ny, nz = normal
                length = math.sqrt(nx * nx + ny * ny + nz * nz)
                shades[count] = AMBIENT + (1 - AMBIENT) * (
                    0.5 + 0.5 * (nx * light[0] + ny * light[1] + nz * light[2]) / length
                )
                face_ids[count] = face
                count += 1


@njit()
def _is_out_of_view(sphere, pose, eye, half_x, half_y, focal, near):
    """Whether a bounding sphere, given in the frame `pose`, is wholly outside the view frustum."""
    x, y, z, radius = sphere[0], sphere[1], sphere[2], sphere[3]
    cx = pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3] - eye[0, 3]
    cy = pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3] - eye[1, 3]
    cz = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3] - eye[2, 3]
    forward = eye[0, 0] * cx + eye[1, 0] * cy + eye[2, 0] * cz
    right = -(eye[0, 1] * cx + eye[1, 1] * cy + eye[2, 1] * cz)
    down = -(eye[0, 2] * cx + eye[1, 2] * cy + eye[2, 2] * cz)
    # Lengths of the inward normals of the frustum's sides, in the axes right, down, forward.
    norm_x = math.sqrt(focal * focal + half_x * half_x)
    norm_y = math.sqrt(focal * focal + half_y * half_y)
    return (
        forward < near - radius
        or half_x * forward - focal * abs(right) < -radius * norm_x
        or half_y * forward - focal * abs(down) < -radius * norm_y
    )


@njit(inline="always")  # measured: a call per face costs 20 % of the pass
def _to_camera(faces, face, sides, world, eye, near, corners, normal):
    """Transform a face to camera axes; return how many of its corners are behind the near plane.

    Back faces return 3, too, unless the face has two sides. `corners` float64 (3, 3) is filled with
    the corners in the axes right, down, forward and `normal` float64 (3,) with the normal of the
    visible side in the world, of any length.
    """
    ex, ey, ez = eye[0, 3], eye[1, 3], eye[2, 3]
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    ax, ay, az = world[a, 0] - ex, world[a, 1] - ey, world[a, 2] - ez
    ux, uy, uz = world[b, 0] - world[a, 0], world[b, 1] - world[a, 1], world[b, 2] - world[a, 2]
    vx, vy, vz = world[c, 0] - world[a, 0], world[c, 1] - world[a, 1], world[c, 2] - world[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    if nx * ax + ny * ay + nz * az >= 0:
        if sides == 1:
            return 3
        nx, ny, nz = -nx, -ny, -nz
    normal[0], normal[1], normal[2] = nx, ny, nz
    n_behind = 0
    for k in range(3):
        i = faces[face, k]
        x, y, z = world[i, 0] - ex, world[i, 1] - ey, world[i, 2] - ez
        corners[k, 0] = -(eye[0, 1] * x + eye[1, 1] * y + eye[2, 1] * z)
        corners[k, 1] = -(eye[0, 2] * x + eye[1, 2] * y + eye[2, 2] * z)
        corners[k, 2] = eye[0, 0] * x + eye[1, 0] * y + eye[2, 0] * z
        n_behind += corners[k, 2] < near
    return n_behind


@njit()
def _sample_bounds(corners, n_behind, half_x, half_y, focal, near):
    """First and last column, first and last row of the part of a face beyond the near plane."""
    low_x = low_y = 1e18  # samples from the centre of the image
    high_x = high_y = -1e18
    for k in range(3):
        z = corners[k, 2]
        if z >= near:
            x, y = focal * corners[k, 0] / z, focal * corners[k, 1] / z
            low_x, high_x = min(low_x, x), max(high_x, x)
            low_y, high_y = min(low_y, y), max(high_y, y)
        if n_behind > 0:
            j = (k + 1) % 3
            if (z >= near) != (corners[j, 2] >= near):
                t = (near - z) / (corners[j, 2] - z)
                x = focal * (corners[k, 0] + t * (corners[j, 0] - corners[k, 0])) / near
                y = focal * (corners[k, 1] + t * (corners[j, 1] - corners[k, 1])) / near
                low_x, high_x = min(low_x, x), max(high_x, x)
                low_y, high_y = min(low_y, y), max(high_y, y)
    width, height = int(2 * half_x), int(2 * half_y)
    return (
        max(0, math.ceil(low_x + half_x - 0.5)),
        min(width - 1, math.floor(high_x + half_x - 0.5)),
        max(0, math.ceil(low_y + half_y - 0.5)),
        min(height - 1, math.floor(high_y + half_y - 0.5)),
    )


@njit(inline="always")
def _fill(corners, uv, half_x, half_y, focal, near, bounds, inverse_depth, slots, plane, slot):
    """Fill the samples where a face is the nearest so far; return False if there are none.

    `plane` float64 (9,) is filled as in :class:`VisibleFaces`.
    """
    ax, ay, az = corners[0]
    bx, by, bz = corners[1]
    cx, cy, cz = corners[2]
    # Rows of the inverse of the matrix whose columns are the corners.
    r0x, r0y, r0z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    r1x, r1y, r1z = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    r2x, r2y, r2z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    determinant = ax * r0x + ay * r0y + az * r0z
    if abs(determinant) < 1e-14:
        return False
    s = 1.0 / determinant
    t = s / focal
    # Barycentric coordinates over depth are linear in sample coordinates: a x + b y + c.
    a0, b0, c0 = r0x * t, r0y * t, r0z * s
    a1, b1, c1 = r1x * t, r1y * t, r1z * s
    a2, b2, c2 = r2x * t, r2y * t, r2z * s
    da, db, dc = a0 + a1 + a2, b0 + b1 + b2, c0 + c1 + c2
    nearest = 1.0 / near
    is_visible = False
    first_x, last_x, first_y, last_y = bounds
    for row in range(first_y, last_y + 1):
        y = row + 0.5 - half_y
        low, high = float(first_x), float(last_x)
        low, high = _clip_row(low, high, a0, b0 * y + c0, half_x)
        low, high = _clip_row(low, high, a1, b1 * y + c1, half_x)
        low, high = _clip_row(low, high, a2, b2 * y + c2, half_x)
        if low > high:
            continue
        start = int(low)
        inverse = da * (start + 0.5 - half_x) + db * y + dc
        for column in range(start, int(high) + 1):
            if inverse > inverse_depth[row, column] and inverse <= nearest:
                inverse_depth[row, column] = inverse
                slots[row, column] = slot
                is_visible = True
            inverse += da
    if is_visible:
        plane[0], plane[1], plane[2] = da, db, dc
        for k in range(2):  # u, v
            plane[3 + 3 * k] = a0 * uv[0, k] + a1 * uv[1, k] + a2 * uv[2, k]
            plane[4 + 3 * k] = b0 * uv[0, k] + b1 * uv[1, k] + b2 * uv[2, k]
            plane[5 + 3 * k] = c0 * uv[0, k] + c1 * uv[1, k] + c2 * uv[2, k]
    return is_visible


@njit()
def _clip_row(low, high, slope, offset, half_x):
    """Clip the columns `low` to `high` to where slope * x + offset is positive."""
    offset += _TOLERANCE
    if slope > 0:
        low = max(low, math.ceil(-offset / slope + half_x - 0.5))
    elif slope < 0:
        high = min(high, math.floor(-offset / slope + half_x - 0.5))
    elif offset < 0:
        return 1.0, 0.0  # empty, and remains so however it is clipped further
    return low, high


@njit()
def shade_pixels(surfaces, samples, visible, supersampling, rgb, segmentation):
    """Shade every pixel with the mean of its samples: the second pass.

    The segmentation id is that of the central sample (the lower right one of an even number).

    Parameters
    ----------
    surfaces : Surfaces
    samples, visible : Samples, VisibleFaces
    supersampling : int
        Samples per pixel in each direction.
    rgb, segmentation : uint8 (h, w, 3), int32 (h, w)
        Filled.
    """
    colours, textures, texture_ids = surfaces.colours, surfaces.textures, surfaces.texture_ids
    segmentation_ids, slots = surfaces.segmentation_ids, samples.slots
    planes, shades, face_ids = visible.planes, visible.shades, visible.face_ids
    height, width = segmentation.shape
    half_x, half_y = width * supersampling / 2, height * supersampling / 2
    scale = 255.0 / (supersampling * supersampling)
    for row in range(height):
        for column in range(width):
            red = green = blue = 0.0
            for i in range(supersampling):
                y = row * supersampling + i + 0.5 - half_y
                for j in range(supersampling):
                    slot = slots[row * supersampling + i, column * supersampling + j]
                    if slot < 0:
                        red += BACKGROUND[0]
                        green += BACKGROUND[1]
                        blue += BACKGROUND[2]
                        continue
                    f = face_ids[slot]
                    shade = shades[slot]
                    t = texture_ids[f]
                    if t >= 0:
                        x = column * supersampling + j + 0.5 - half_x
                        p = planes[slot]
                        z = 1.0 / (p[0] * x + p[1] * y + p[2])
                        u = math.floor((p[3] * x + p[4] * y + p[5]) * z * TEXTURE_SIZE)
                        v = math.floor((p[6] * x + p[7] * y + p[8]) * z * TEXTURE_SIZE)
                        texel = textures[t, v & (TEXTURE_SIZE - 1), u & (TEXTURE_SIZE - 1)]
                        shade /= 255.0
                        red += shade * colours[f, 0] * texel[0]
                        green += shade * colours[f, 1] * texel[1]
                        blue += shade * colours[f, 2] * texel[2]
                    else:
                        red += shade * colours[f, 0]
                        green += shade * colours[f, 1]
                        blue += shade * colours[f, 2]
            rgb[row, column, 0] = int(min(red * scale + 0.5, 255.0))
            rgb[row, column, 1] = int(min(green * scale + 0.5, 255.0))
            rgb[row, column, 2] = int(min(blue * scale + 0.5, 255.0))
            middle = supersampling // 2
            slot = slots[row * supersampling + middle, column * supersampling + middle]
            segmentation[row, column] = segmentation_ids[face_ids[slot]] if slot >= 0 else 0
