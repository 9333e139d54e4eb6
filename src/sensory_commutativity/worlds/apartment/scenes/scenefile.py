"""Load a scene from its YAML file. The key ``kind`` selects a floor plan or a mesh."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from ....errors import ConfigError
from ....storage.settings import Section
from ....storage.settings_errors import check_json_value, explain
from ....storage.yamlfile import read_yaml
from .floorplan import FloorPlan, build_floor_plan
from .meshscene import MeshScene, build_mesh_scene
from .scene import Scene, SceneError

_EXPECTED = "a scene, e.g. config/apartments/rs-stand-in.yaml"
AnySection = TypeVar("AnySection", bound=Section)


def load_scene(file: str | Path) -> Scene:
    """Load a scene.

    Raises
    ------
    SceneError
        With one line: the file, the problem and the remedy.
    """
    path = Path(file)
    settings = read_yaml(path, SceneError, _EXPECTED)
    kind = settings.get("kind") if isinstance(settings, dict) else None
    if kind == "floor-plan":
        return build_floor_plan(_parse(FloorPlan, settings, path), path)
    if kind == "mesh":
        return build_mesh_scene(_parse(MeshScene, settings, path), path)
    raise SceneError(
        f"{path}: kind: expected floor-plan or mesh, got {kind!r}; see config/apartments/README.md"
    )


def list_scene_files(file: str | Path) -> list[Path]:
    """Return all files that a valid scene is built from: its YAML file and its mesh, if any."""
    path = Path(file)
    mesh = read_yaml(path, SceneError, _EXPECTED).get("mesh")
    return [path] if mesh is None else [path, path.parent / mesh]


def _parse(section: type[AnySection], settings: Any, path: Path) -> AnySection:
    try:
        check_json_value(settings, "scene")
        return section.model_validate_json(json.dumps(settings))
    except ConfigError as error:
        raise SceneError(f"{path}: {error}") from None
    except ValidationError as error:
        raise SceneError(f"{path}: {explain(error, section).removeprefix('config: ')}") from None
