"""Making environments by name, whichever package registers them."""

from __future__ import annotations

import difflib
import importlib
import re
from typing import Any

from ..errors import ArgumentError, UserError
from ..extras import install_command

PROVIDERS = {
    r"Fetch|Hand|Adroit|Franka|Ant[MS]|Point[MS]|MaMuJoCo": "gymnasium_robotics",
    r"Panda": "panda_gym",
    r"dm_control/": "shimmy",
    r"SensoryCommutativity/": "sensory_commutativity.worlds.flatland.environment",
}
"""Beginning of a name -> the package that registers it."""
NO_LIMIT = 10**9
"""Steps of an episode; an order is longer than the episodes of most tasks."""


def make_environment(name: str, **options: Any) -> Any:
    """Make a Gymnasium environment without a limit of steps and without Gymnasium's own checks.

    Parameters
    ----------
    name : str
        E.g. ``Pusher-v5``, ``FetchPush-v4`` or ``dm_control/cheetah-run-v0``.
    **options
        Of ``gymnasium.make``.

    Raises
    ------
    ArgumentError
        If there is no such environment; with near names.
    UserError
        If a package that it needs is not installed; with the command that installs it.
    """
    try:
        import gymnasium
    except ModuleNotFoundError:
        raise UserError(
            f"{name}: Gymnasium is not installed; run {install_command('environments')}"
        ) from None
    _register(name, gymnasium)
    try:
        return gymnasium.make(name, max_episode_steps=NO_LIMIT, disable_env_checker=True, **options)
    except TypeError as error:
        raise ArgumentError(f"env: {name}: {' '.join(str(error).split())}") from None
    except gymnasium.error.DependencyNotInstalled as error:
        reason = " ".join(str(error).split())
        raise UserError(
            f"{name}: needs a package that is not installed ({reason[:100]}); run "
            f"{install_command('environments')}"
        ) from None
    except (gymnasium.error.Error, ModuleNotFoundError) as error:
        near = difflib.get_close_matches(name, list(gymnasium.registry), 3, 0.6)
        hint = f"; did you mean {', '.join(near)}?" if near else ""
        reason = " ".join(str(error).split())[:120].rstrip(".")
        raise ArgumentError(
            f"env: there is no Gymnasium environment {name!r} ({reason}){hint}"
        ) from None


def _register(name: str, gymnasium: Any) -> None:
    """Import the package that registers environments with such names."""
    for pattern, module in PROVIDERS.items():
        if not re.match(pattern, name):
            continue
        try:
            provider = importlib.import_module(module)
        except ModuleNotFoundError:
            raise UserError(
                f"{name}: the package {module} is not installed; run "
                f"{install_command('environments')}"
            ) from None
        if module == "gymnasium_robotics":
            gymnasium.register_envs(provider)
