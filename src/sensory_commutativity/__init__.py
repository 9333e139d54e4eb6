"""Sensory commutativity of action sequences for embodied agents.

Play the same actions in two orders from the same start: do the sensors end equal? The names below
are the public API; they are imported when they are first used.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_MODULES = {
    "measurement.logs": ("measure_log",),
    "measurement.measure": ("measure",),
    "measurement.measurement": ("Measurement",),
    "measurement.order": ("DofOrder",),
    "measurement.recorder": ("Recorder", "write_log"),
    "scp.check": ("CheckResult", "WorldReport", "check_world"),
    "scp.world": (
        "Dof", "EventReporter", "InverseReporter", "Resting", "SequenceLimiter", "SequencePlayer",
        "SteppableWorld", "World", "play",
    ),
    "scp.return_protocol": ("Legs", "compare_legs", "play_trial"),
    "scp.sequences": ("compose", "inverse", "no_op", "permute", "sample_sequence"),
    "scp.experiment": (
        "commutation_experiment", "compare_orders", "distances_per_dof", "endings_per_dof",
        "iterate_order", "play_order",
    ),
    "scp.equivalence": ("commutative_residue", "commute", "equivalent", "is_commutative_residue"),
    "scp.distances": ("mean_squared_error",),
    "scp.estimate": ("commutes", "estimate_scp"),
    "adapters": ("as_world",),
    "adapters.gymnasium": ("GymnasiumWorld", "from_gymnasium"),
    "adapters.noise": ("NoisyWorld",),
    "adapters.registry": ("make_environment",),
    "adapters.snapshots": ("Exactness", "ExactSnapshot", "choose_snapshots", "measure_exactness"),
    "worlds.catalog": ("make_apartment", "make_world"),
    "worlds.corridor": ("Corridor",),
    "worlds.flatland.agent": ("Polyphemus",),
    "worlds.flatland.environment": ("FlatlandEnv",),
    "worlds.flatland.room": ("Room",),
    "worlds.flatland.world": ("FlatlandWorld",),
    "worlds.apartment.world": ("ApartmentWorld",),
    "change_detection.predict": ("Change", "predict_change"),
    "navigation.action_spaces": (
        "ScaledAction", "VectorScaledAction", "action_scales", "wrap_action_space",
    ),
    "seeding": ("generator", "seed_for"),
    "errors": ("ArgumentError", "MissingExtraError", "UserError", "WorldError"),
}  # fmt: skip
"""Module -> the public names that it defines."""
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}

_EXTRAS = {
    "adapters": "environments",
    "change_detection": "change-detection",
    "navigation.action_spaces": "environments",
    "navigation": "navigation",
    "worlds.apartment": "apartment",
    "worlds.flatland": "flatland",
}
"""Package -> the extra that it needs."""

__all__ = ["__version__", *sorted(_MODULE_OF)]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .extras import extra_needed

    package = _MODULE_OF[name]
    extra = next((extra for part, extra in _EXTRAS.items() if package.startswith(part)), None)
    with extra_needed(extra):
        module = importlib.import_module(f".{package}", __name__)
    return getattr(module, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
