"""Sensory commutativity of action sequences for embodied agents: play the same actions in two orders; did the sensors end equal?"""

from importlib.metadata import version

__version__ = version("sensory-commutativity")
