"""Optional parts of the package, and what to install when one of them is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from .errors import MissingExtraError

EXTRAS = {
    "flatland": ("numba", "pymunk", "gymnasium"),
    "apartment": ("pybullet", "trimesh", "fast_simplification", "gymnasium_robotics", "collada"),
    "xacro": ("xacro",),
    "environments": ("mujoco", "panda_gym", "shimmy", "dm_control", "Box2D", "pygame"),
    "change-detection": ("torch", "torchvision", "h5py", "onnx"),
    "navigation": ("stable_baselines3", "sb3_contrib"),
    "workflow": ("snakemake", "rocrate", "scipy", "statsmodels"),
}
"""Extra -> the modules that it adds to those before it; as in pyproject.toml."""


def install_command(extra: str) -> str:
    """The shell command that installs an extra."""
    return f"pip install 'sensory-commutativity[{extra}]'"


def missing_extra(error: ModuleNotFoundError, extra: str | None = None) -> MissingExtraError | None:
    """The error to show for a module that is not installed; None if no extra provides it.

    Parameters
    ----------
    error : ModuleNotFoundError
    extra : str, optional
        The extra that the caller belongs to, if several need the module.
    """
    module = (error.name or "").partition(".")[0]
    provider = next((name for name, modules in EXTRAS.items() if module in modules), None)
    if provider is None:
        return None
    command = install_command(extra or provider)
    return MissingExtraError(f"the package {module} is not installed; run {command}")


@contextmanager
def extra_needed(extra: str | None = None) -> Iterator[None]:
    """Turn the failing import of an optional package into a MissingExtraError."""
    try:
        yield
    except ModuleNotFoundError as error:
        missing = missing_extra(error, extra)
        if missing is None:
            raise
        raise missing from None
