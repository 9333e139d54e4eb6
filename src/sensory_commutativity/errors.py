"""Errors that the user can correct: one line each; the command line exits with code 2."""

from __future__ import annotations


class UserError(Exception):
    """A request cannot be fulfilled; the message names the key or path and the remedy."""


class ArgumentError(UserError, ValueError):
    """An argument of a public function is not valid; the message begins with its name."""


class ConfigError(UserError):
    """The configuration is not valid."""


class MissingExtraError(UserError, ImportError):
    """An optional part of the package is needed and not installed; the message says which."""


class TableError(UserError):
    """A table is missing, damaged, incomplete, or not the table that was asked for."""


class WorldError(UserError):
    """A world breaks a promise that the SC-experiment rests on."""
