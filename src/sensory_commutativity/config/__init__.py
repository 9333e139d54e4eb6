"""The configuration: what can be set, within which limits, and why a wrong setting is refused.

One typed model per stage; unknown keys are refused; what depends on several keys is checked when the configuration is loaded. The JSON schema in
``config/schema.json`` is generated from these models (``sensory-commutativity schema``), and a test fails when they drift apart.
"""

from .apartment import ApartmentConfig, ApartmentRun
from .flatland import BaselinesConfig, FlatlandConfig, Run
from .loading import joint_range, json_schema, load, merge, validate, write_resolved
from .masks import LEARNED, MasksConfig, ModelName
from .navigation import LearnerConfig, NavigationConfig
from .whole import Config

__all__ = [
    "LEARNED",
    "ApartmentConfig",
    "ApartmentRun",
    "BaselinesConfig",
    "Config",
    "FlatlandConfig",
    "LearnerConfig",
    "MasksConfig",
    "ModelName",
    "NavigationConfig",
    "Run",
    "joint_range",
    "json_schema",
    "load",
    "merge",
    "validate",
    "write_resolved",
]
