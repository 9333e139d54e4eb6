"""The argument WORLD: a world of the package, a Gymnasium environment, or one's own."""

from __future__ import annotations

import difflib
import importlib
import importlib.util
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..adapters import as_world
from ..adapters.registry import make_environment
from ..errors import ArgumentError, UserError
from ..scp.world import World

OWN = re.compile(r"^(?P<module>[\w./\\ -]+):(?P<name>[A-Za-z_]\w*)$")
"""FILE.py:NAME or MODULE:NAME. Gymnasium's MODULE:NAME-v0 does not match."""
WORLD_OPTIONS = ("control", "snapshots", "sensors", "avoid_stops", "prefix", "hold", "settle")
"""Options that belong to the adapter of environments; the others go to gymnasium.make."""


def world_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The argument WORLD and the options that say which."""
    for decorator in (
        click.option(
            "-o", "--option", "options", multiple=True, metavar="KEY=VALUE",
            help="Option of the world, e.g. -o objects=4; may be given several times.",
        ),
        click.option(
            "--sensors",
            help="Keys of an environment's observation, with commas; or world (sensors that move "
            "only if something is touched); or pixels.",
        ),
        click.option(
            "--control", type=click.Choice(["auto", "direct", "increments", "servo"]),
            help="How actions become commands of an environment  [default: auto]",
        ),
        click.option("--scene", help="Scene of the apartment: a name, or a YAML file."),
        click.option("--robot", help="Robot in the apartment: a name, or a YAML file."),
        click.option("--list", "list_names", is_flag=True,
                     help="List worlds, robots and scenes, and exit."),
        click.argument("world", required=False),
    ):  # fmt: skip
        function = decorator(function)
    return function


def list_worlds() -> None:
    """Print the names that WORLD, --robot and --scene may have."""
    from ..worlds.catalog import WORLDS, list_robots, list_scenes

    for kind, names in (
        ("worlds", list(WORLDS)), ("robots", list_robots()), ("scenes", list_scenes())
    ):  # fmt: skip
        click.echo(f"{kind}: {', '.join(names)}")


def build_world(
    world: str | None, options: tuple[str, ...], which: dict[str, str | None], restored: bool = True
) -> World:
    """Build the world that the command line names; `which` holds the options that say which.

    If nothing is to be `restored`, an environment makes no snapshots, and a world of one's own may
    be without.

    Raises
    ------
    UserError
        If there is no such world, or one of its options is not valid.
    """
    from ..worlds.catalog import WORLDS, make_world

    chosen = _read_options(options)
    chosen |= {key: value for key, value in which.items() if value is not None}
    apartment = which.get("robot") or which.get("scene")
    if world is None and apartment:
        world = "apartment"
    if world is None:
        raise click.UsageError("give a WORLD, or a --robot; --list shows all names")
    if apartment and world != "apartment":
        raise click.UsageError("--robot and --scene belong to the world apartment")
    own = OWN.match(world)
    if not restored and world not in WORLDS:
        chosen["snapshots"] = "none"
    if (which.get("control") or which.get("sensors")) and world in WORLDS:
        raise click.UsageError("--control and --sensors belong to Gymnasium environments")
    if world in WORLDS:
        return make_world(world, **chosen)
    if own:
        adapter = _split_options(chosen)
        source = _call(_load_own(own["module"], own["name"]), chosen, world)
        if hasattr(source, "action_space"):
            return _adapt(source, adapter)
        return as_world(source) if restored else source
    return _make_environment(world, chosen, list(WORLDS))


def _read_options(options: tuple[str, ...]) -> dict[str, Any]:
    """KEY=VALUE; the value is read as YAML."""
    import yaml

    chosen = {}
    for option in options:
        key, equals, text = option.partition("=")
        if not equals or not key.isidentifier():
            raise click.UsageError(f"-o {option}: expected KEY=VALUE")
        try:
            chosen[key] = yaml.safe_load(text)
        except yaml.YAMLError:
            raise click.UsageError(f"-o {option}: the value cannot be read as YAML") from None
    return chosen


def _load_own(module: str, name: str) -> Any:
    """What FILE.py or MODULE calls `name`."""
    if module.endswith(".py"):
        path = Path(module)
        if not path.is_file():
            raise UserError(f"{module}: there is no such file; give FILE.py:NAME")
        sys.path.insert(0, str(path.resolve().parent))
        spec = importlib.util.spec_from_file_location(path.stem, path)
        assert spec is not None and spec.loader is not None
        loaded = importlib.util.module_from_spec(spec)
        sys.modules[path.stem] = loaded
        spec.loader.exec_module(loaded)
    else:
        sys.path.insert(0, "")
        try:
            loaded = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if (error.name or "") != module.partition(".")[0] and error.name != module:
                raise
            raise UserError(f"{module}: there is no such module; give FILE.py:NAME") from None
    if not hasattr(loaded, name):
        public = [one for one in vars(loaded) if not one.startswith("_")]
        near = difflib.get_close_matches(name, public, 1, 0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise UserError(f"{module}: has no {name}{hint}")
    return getattr(loaded, name)


def _call(source: Any, options: dict[str, Any], world: str) -> Any:
    """The world itself; a function or a class is called with the options."""
    if not callable(source) or (isinstance(source, World) and not isinstance(source, type)):
        if options:
            raise UserError(f"{world}: is a world, not a function; leave out -o")
        return source
    try:
        return source(**options)
    except TypeError as error:
        if "argument" not in str(error):
            raise
        raise UserError(f"{world}: {error}; see -o") from None


def _make_environment(name: str, options: dict[str, Any], worlds: list[str]) -> Any:
    """The Gymnasium environment `name`, as a world."""
    near = difflib.get_close_matches(name, worlds, 1, 0.6)
    hint = f"; did you mean the world {near[0]}?" if near else ""
    for_world = _split_options(options)
    if for_world.get("sensors") == ["pixels"]:
        options.setdefault("render_mode", "rgb_array")
    try:
        env = make_environment(name, **options)
    except UserError as error:
        raise ArgumentError(f"WORLD: {error}{hint}; --list shows the package's own") from None
    return _adapt(env, for_world)


def _split_options(options: dict[str, Any]) -> dict[str, Any]:
    """Take the options of the adapter out of `options`."""
    adapter = {key: options.pop(key) for key in WORLD_OPTIONS if key in options}
    if isinstance(adapter.get("sensors"), str):
        adapter["sensors"] = adapter["sensors"].split(",")
    return adapter


def _adapt(env: Any, options: dict[str, Any]) -> World:
    from ..adapters.gymnasium import from_gymnasium

    return from_gymnasium(env, **options)
