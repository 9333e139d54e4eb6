"""Errors that are the user's to mend: shown as one line, exit code 2."""

from __future__ import annotations


class UserError(Exception):
    """Something the user asked for cannot be done; the message names the key or path and the remedy."""


class ConfigError(UserError):
    """The configuration is not valid."""


class TableError(UserError):
    """A table is missing, damaged, or not what its name says."""
