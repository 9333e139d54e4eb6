"""Errors that the user can correct: shown as one line, exit code 2."""

from __future__ import annotations


class UserError(Exception):
    """A request cannot be fulfilled; the message names the key or path and the remedy."""


class ConfigError(UserError):
    """The configuration is not valid."""


class TableError(UserError):
    """A table is missing, damaged, incomplete, or not the table that was asked for."""
