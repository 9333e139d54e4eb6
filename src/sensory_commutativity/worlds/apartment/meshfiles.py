"""Mesh files as modelling tools, scanners and ROS packages write them, with their colours.

trimesh reads the formats. Around it, files are bounded before they are read, what they refer to
is found and checked, Collada's unit is applied, and vertices that are no numbers are refused. The
``up_axis`` of Collada is ignored, as RViz and MoveIt ignore it.
"""

from __future__ import annotations

import io
import json
import logging
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np

from .files import FileError, check_file, locate
from .geometry import project_texture
from .scenes.scene import Mesh, Vector

MESH_FORMATS = (".stl", ".obj", ".dae", ".ply", ".glb", ".gltf", ".off")
"""Formats that are read; trimesh alone would also unpack archives and use further packages."""
MAX_BYTES = 300_000_000
"""Size of a mesh file; chosen: a scan of 3 million faces in ASCII."""
MAX_FACES = 3_000_000
"""Chosen: three times what scanners of rooms write; takes 2 GB."""
MAX_PIXELS = 8192 * 8192
"""Pixels of a picture that colours a mesh; chosen: the largest that graphics cards take."""
SAMPLES = 2_000_000
"""Points at which the pictures of a mesh are read in all; chosen: takes a second."""
_PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".tga", ".webp", ".dds",
             ".ktx2", ".hdr", ".exr")  # fmt: skip
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
GREY = (4, (100, 100, 100))
"""Pixels, and their colour, of the picture that trimesh invents for a mesh without one."""
_UNIT = re.compile(rb"<unit\b[^<>]{0,200}?\bmeter\s*=\s*[\"']([^\"'<>]{1,40})[\"']")


class _Resolver:
    """Gives trimesh the files that a mesh names, checked; `missing` says what it did not get."""

    def __init__(self, folder: Path):
        self._folder = folder
        self.missing: dict[str, str] = {}

    def get(self, name: str) -> bytes:
        name = _without_options(str(name).strip().strip('"'))
        try:
            path = locate(name, self._folder)
            check_file(path, MAX_BYTES)
        except FileError as error:
            self.missing[name] = str(error)
            raise FileNotFoundError(name) from None
        content = path.read_bytes()
        if path.suffix.lower() in _PICTURES:
            problem = _picture_problem(content)
            if problem is not None:
                self.missing[name] = problem
                raise FileNotFoundError(name)
        return content

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def keys(self) -> list[str]:
        return []

    def namespaced(self, namespace: str) -> _Resolver:
        return _Resolver(self._folder / namespace)

    def write(self, name: str, data: bytes) -> None:
        raise PermissionError(name)


def _without_options(name: str) -> str:
    """The name of a picture in an MTL file, without options such as ``-s 1 1 1``."""
    words = name.split(" ")
    while words and re.fullmatch(r"-[A-Za-z]\w*", words[0]):
        words.pop(0)
        while len(words) > 1 and re.fullmatch(r"[-+.\d][-+.\deE]*|on|off|[rgbmlz]", words[0]):
            words.pop(0)
    return " ".join(words)


def load_mesh(path: Path, max_faces: int | None = None) -> Mesh:
    """Read a mesh file, all its parts as one mesh, in metres if the format has a unit.

    Parameters
    ----------
    path : Path
    max_faces : int, optional
        Simplify the mesh to about this many triangles.

    Raises
    ------
    FileError
        The file cannot be read as a mesh; the message continues "the file ...".
    """
    vertices, faces, _, _ = _read(path, colours=False)
    return simplify(vertices, faces, max_faces)


def load_coloured_mesh(path: Path) -> tuple[Mesh, np.ndarray | None, dict[str, str]]:
    """Read a mesh file with the colour of every face.

    Returns
    -------
    mesh : Mesh
        As :func:`load_mesh` reads it.
    colours : float64 (m, 3) or None
        Red, green and blue in [0, 1], from vertices, faces, materials or pictures, averaged over
        each face; None if the file has none.
    missing : dict
        Files that it names and that cannot be read -> what is wrong with them.

    Raises
    ------
    FileError
    """
    vertices, faces, colours, missing = _read(path, colours=True)
    return project_texture(vertices, faces), colours, missing


def simplify(vertices: np.ndarray, faces: np.ndarray, max_faces: int | None) -> Mesh:
    """Return a mesh of about `max_faces` triangles at most."""
    import fast_simplification

    if max_faces is not None and len(faces) > max_faces:
        simple_vertices, simple_faces = fast_simplification.simplify(
            vertices.astype(np.float32), faces.astype(np.int32), target_count=max_faces
        )
        vertices = np.asarray(simple_vertices, np.float64)
        faces = np.asarray(simple_faces, np.int64)
    return project_texture(vertices, faces)


def _read(
    path: Path, colours: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, dict[str, str]]:
    """Return vertices and faces, equal vertices merged; colours of faces; files that are missing.

    Raises FileError.
    """
    import trimesh

    _check_content(path, check_file(path, MAX_BYTES))
    resolver = _Resolver(path.parent)
    given: Any = resolver
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it tells in lines of its own
    kind = path.suffix[1:].lower()
    try:
        with path.open("rb") as file:
            scene: Any = trimesh.load_scene(file, file_type=kind, resolver=given, process=False)
        meshes = _list_meshes(scene)
        if not meshes and kind == "dae":  # pycollada leaves out what has a broken material
            plain = io.BytesIO(_without_materials(path.read_bytes()))
            scene = trimesh.load_scene(plain, file_type=kind, resolver=given, process=False)
            meshes = _list_meshes(scene)
    except ModuleNotFoundError:
        raise FileError(
            "needs the package pycollada; run pip install 'sensory-commutativity[apartment]'"
        ) from None
    except FileError:
        raise
    except Exception as error:  # the readers of the many formats raise all kinds of errors
        if resolver.missing:
            name, problem = next(iter(resolver.missing.items()))
            raise FileError(f"names {name!r}, which {problem}") from None
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise FileError(f"cannot be read as a mesh ({reason}); replace or convert it") from None
    if not meshes:
        raise FileError("holds no triangles; export it again, as triangles")
    shades = [_face_colours(mesh) for mesh, _ in meshes] if colours else []
    vertices, faces = _join(meshes)
    _check_numbers(vertices, faces)
    if path.suffix.lower() == ".dae":
        vertices = vertices * _collada_unit(path)
    joined = trimesh.Trimesh(vertices, faces, process=False)
    joined.merge_vertices(merge_tex=True, merge_norm=True)
    merged = np.asarray(joined.vertices, np.float64), np.asarray(joined.faces, np.int64)
    return *merged, _join_colours(meshes, shades), resolver.missing


def _list_meshes(scene: Any) -> list[tuple[Any, np.ndarray]]:
    """The meshes of a trimesh ``Scene``, with the frame of each place where they occur."""
    import trimesh

    meshes, total = [], 0
    for node in scene.graph.nodes_geometry:
        frame, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            total += len(mesh.faces)
            if total > MAX_FACES:
                raise FileError(f"has more than {MAX_FACES:,} faces; simplify it first")
            meshes.append((mesh, np.asarray(frame, np.float64)))
    return meshes


def _join(meshes: list[tuple[Any, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces, start = [], [], 0
    for mesh, frame in meshes:
        points, triangles = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
        if not np.array_equal(frame, np.eye(4)):
            points = points @ frame[:3, :3].T + frame[:3, 3]
            if np.linalg.det(frame[:3, :3]) < 0:  # mirrored: keep faces counter-clockwise
                triangles = triangles[:, ::-1]
        vertices.append(points)
        faces.append(triangles + start)
        start += len(points)
    return np.concatenate(vertices), np.concatenate(faces)


def _check_numbers(vertices: np.ndarray, faces: np.ndarray) -> None:
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FileError("has faces of vertices that do not exist; export it again")
    wrong = ~np.isfinite(vertices).all(1)
    wrong &= np.isin(np.arange(len(vertices)), faces) if wrong.any() else wrong
    if wrong.any():
        raise FileError(
            f"has {int(wrong.sum())} vertices that are no finite numbers (first: number "
            f"{int(wrong.argmax()) + 1}); repair it"
        )


# ---- before reading --------------------------------------------------------------------------


def _check_content(path: Path, head: bytes) -> None:
    """Check what a file declares about itself, before memory is taken for it."""
    suffix = path.suffix.lower()
    if suffix == ".dae":
        content = path.read_bytes()
        if b"<!ENTITY" in content or b"<\0!\0E\0N\0T" in content:
            raise FileError("declares entities, which are not read; export it again")
    elif suffix in (".gltf", ".glb"):
        _check_gltf(_read_gltf(path, head))
    elif suffix == ".ply":
        size = path.stat().st_size
        for kind, count in re.findall(rb"element\s+(\w+)\s+(\d{1,20})", head + b"\n"):
            if int(count) > size:
                raise FileError(
                    f"declares {int(count):,} of {kind.decode('ascii', 'replace')} in {size:,} "
                    "bytes; it is damaged, export it again"
                )


def _read_gltf(path: Path, head: bytes) -> dict[str, Any]:
    """The JSON of a glTF file."""
    if head.startswith(b"glTF"):
        version, _, length, kind = struct.unpack("<IIII", head[4:20].ljust(16, b"\0"))
        if version != 2 or kind != 0x4E4F534A or length > path.stat().st_size:
            raise FileError("is not binary glTF 2.0, or damaged; export it again")
        with path.open("rb") as file:
            file.seek(20)
            text = file.read(length)
    else:
        text = path.read_bytes()
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise FileError("is not glTF: its JSON is not valid; export it again") from None
    return content if isinstance(content, dict) else {}


def _check_gltf(content: dict[str, Any]) -> None:
    required = content.get("extensionsRequired") or content.get("extensionsUsed") or []
    for extension in _COMPRESSED:
        if extension in required:
            name = "Draco" if "draco" in extension else "meshopt"
            raise FileError(
                f"is compressed by {name}, which cannot be read; export it without compression"
            )
    accessors = content.get("accessors") or []
    counts = [accessor.get("count") for accessor in accessors if isinstance(accessor, dict)]
    if any(not isinstance(count, int) or count > 4 * MAX_FACES for count in counts):
        raise FileError(f"has more than {MAX_FACES:,} faces, or is damaged; simplify it first")


def _without_materials(content: bytes) -> bytes:
    """A Collada file whose meshes name no materials."""
    parts, position, closing = [], 0, b"</bind_material>"
    while (start := content.find(b"<bind_material", position)) >= 0:
        end = content.find(closing, start)
        if end < 0:
            break
        parts.append(content[position:start])
        position = end + len(closing)
    return b"".join([*parts, content[position:]])


def _collada_unit(path: Path) -> float:
    """Metres per unit of a Collada file."""
    with path.open("rb") as file:
        found = _UNIT.search(file.read(1_000_000))
    try:
        metres = float(found[1]) if found else 1.0
    except ValueError:
        metres = float("nan")
    if not 1e-6 <= metres <= 1e6:
        raise FileError(f"gives its unit as {found[1]!r} metres; correct <unit>" if found else "")
    return metres


# ---- colours ---------------------------------------------------------------------------------


def _join_colours(
    meshes: list[tuple[Any, np.ndarray]], colours: list[np.ndarray | None]
) -> np.ndarray | None:
    if all(colour is None for colour in colours):
        return None
    grey = np.full((1, 3), 0.75)
    return np.concatenate(
        [
            np.repeat(grey, len(mesh.faces), 0) if colour is None else colour
            for (mesh, _), colour in zip(meshes, colours, strict=True)
        ]
    )


def _face_colours(mesh: Any) -> np.ndarray | None:
    """Colours of the faces of a trimesh ``Trimesh``: float64 (m, 3) in [0, 1], or None."""
    visual, n = mesh.visual, len(mesh.faces)
    if visual.kind in ("vertex", "face"):
        return np.asarray(visual.face_colors, np.float64)[:, :3] / 255
    if visual.kind != "texture":
        return None
    materials = getattr(visual.material, "materials", None)
    if materials and getattr(visual, "face_materials", None) is not None:
        chosen = np.asarray(visual.face_materials)
        colours = np.full((n, 3), 0.75)
        for k, material in enumerate(materials):
            of_material = np.flatnonzero(chosen == k)
            colours[of_material] = _material_colours(mesh, material, of_material)
        return colours
    if _is_default(visual.material):
        return None
    return _material_colours(mesh, visual.material, np.arange(n))


def _is_default(material: Any) -> bool:
    """Whether a material is the one that trimesh gives to meshes without a material."""
    import trimesh

    simple, image = trimesh.visual.material.SimpleMaterial, getattr(material, "image", None)
    if type(material) is not simple or list(material.diffuse) != list(simple().diffuse):
        return False
    return image is None or (image.size == (2, 2) and image.convert("RGB").getcolors() == [GREY])


def _material_colours(mesh: Any, material: Any, faces: np.ndarray) -> np.ndarray:
    """Colours of some faces that have a material: float64 (k, 3)."""
    pbr = hasattr(material, "baseColorFactor")
    picture = material.baseColorTexture if pbr else getattr(material, "image", None)
    factor = _factor(material.baseColorFactor if pbr else getattr(material, "diffuse", None))
    colours = np.tile(np.ones(3) if factor is None else factor, (len(faces), 1))
    if picture is not None:
        shades = _picture_colours(picture, mesh.visual.uv, np.asarray(mesh.faces)[faces])
        # Other formats often give a black or grey colour beside the picture that replaces it.
        colours = colours * shades if pbr else shades
    vertex_colours = mesh.vertex_attributes.get("color") if pbr else None
    if vertex_colours is not None and len(vertex_colours) == len(mesh.vertices):
        values = np.asarray(vertex_colours, np.float64)[:, :3]
        values = values / (255 if np.asarray(vertex_colours).dtype.kind in "ui" else 1)
        colours = colours * values[np.asarray(mesh.faces)[faces]].mean(1)
    return np.clip(colours, 0, 1)


def _factor(value: Any) -> np.ndarray | None:
    """A material's colour, of whole numbers to 255 or of floats to 1: float64 (3,)."""
    if value is None:
        return None
    array = np.asarray(value)
    colour = array.astype(np.float64)[:3] / (255 if array.dtype.kind in "ui" else 1)
    return colour if colour.shape == (3,) and np.isfinite(colour).all() else None


def _picture_problem(content: bytes) -> str | None:
    """Why a picture cannot be used; None if it can."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content)) as picture:
            width, height = picture.size
            if width * height <= MAX_PIXELS:
                picture.verify()
                return None
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return "cannot be read as a picture; convert it to PNG or JPEG"
    return f"has {width} x {height} pixels, more than 8192 x 8192; make it smaller"


def _picture_colours(picture: Any, uv: Any, faces: np.ndarray) -> np.ndarray:
    """Mean colour of a picture over each face: float64 (k, 3)."""
    width, height = picture.size
    if width * height > MAX_PIXELS:
        raise FileError(
            f"has a picture of {width} x {height} pixels, more than 8192 x 8192; make it smaller"
        )
    pixels = np.asarray(picture.convert("RGB"), np.uint8)  # also of palettes
    if uv is None or len(uv) == 0:
        return np.tile(pixels.reshape(-1, 3).mean(0) / 255, (len(faces), 1))
    corners = np.nan_to_num(np.asarray(uv, np.float64)[:, :2][faces])  # (k, 3, 2)
    per_side = int(np.clip(np.sqrt(2 * SAMPLES / max(len(faces), 1)), 3, 24))
    total, weights = np.zeros((len(faces), 3)), _barycentric_grid(per_side)
    for weight in weights:
        u, v = np.einsum("c,kcd->dk", weight, corners)
        column = np.minimum(((u % 1.0) * width).astype(np.int64), width - 1)
        row = np.minimum(((1 - v) % 1.0 * height).astype(np.int64), height - 1)
        total += pixels[row, column]
    return total / len(weights) / 255


def mean_picture_colour(path: Path) -> Vector | None:
    """Mean colour of a picture file, each channel in [0, 1]; None if it cannot be read."""
    from PIL import Image

    try:
        check_file(path, MAX_BYTES)
        with Image.open(path) as picture:
            if picture.size[0] * picture.size[1] > MAX_PIXELS:
                return None
            r, g, b = np.asarray(picture.convert("RGB")).reshape(-1, 3).mean(0) / 255
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None
    return float(r), float(g), float(b)


def _barycentric_grid(n: int) -> np.ndarray:
    """Points that are spread evenly inside a triangle: float64 (n (n + 1) / 2, 3)."""
    points = [(i + 1 / 3, j + 1 / 3) for i in range(n) for j in range(n - i)]
    first = np.array(points) / n
    return np.column_stack([first, 1 - first.sum(1)])
