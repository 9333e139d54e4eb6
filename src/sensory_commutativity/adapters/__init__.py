"""Other people's environments as worlds."""

from __future__ import annotations

from typing import Any

from ..errors import ArgumentError
from ..scp.check import require_world
from ..scp.world import World

ENVIRONMENT_PARTS = ("action_space", "observation_space", "reset", "step")


def as_world(source: Any, **options: Any) -> World:
    """Return `source` as a :class:`~sensory_commutativity.scp.world.World`.

    Parameters
    ----------
    source : World, Gymnasium environment, or callable
        A callable without arguments that returns one of the others.
    **options
        For an environment: of :class:`.GymnasiumWorld`.

    Raises
    ------
    ArgumentError
        If it is none of these; the message says what is missing.
    """
    if isinstance(source, type):
        require_world(source)  # says how to make one
    if isinstance(source, World):
        return source
    if hasattr(source, "single_action_space"):
        raise ArgumentError(
            "world: a vector environment holds several; give one environment, and workers=..."
        )
    if all(hasattr(source, name) for name in ENVIRONMENT_PARTS):
        from .gymnasium import from_gymnasium

        return from_gymnasium(source, **options)
    if isinstance(source, str):
        raise ArgumentError(
            f"world: expected a world or an environment, got the text {source!r}; write "
            f"make_world({source!r}), or gymnasium.make({source!r})"
        )
    if callable(source):
        return as_world(source(), **options)
    require_world(source)
    return source
