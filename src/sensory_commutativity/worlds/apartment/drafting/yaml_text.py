"""Writes a drafted description as a YAML file with comments, a line per degree of freedom."""

from __future__ import annotations

from typing import Any

import yaml

from .draft import Draft


def format_draft(draft: Draft, command: str) -> str:
    """Return the text of the YAML file.

    Parameters
    ----------
    draft : Draft
    command : str
        The command that made it, for the first line.
    """
    settings, comments = draft.settings, draft.comments
    lines = [f"# Written by {command}. Guesses: check them with sencom robot check."]
    lines += [f"# Note: {note}." for note in draft.notes]
    for key in ("name", "urdf", "height"):
        if key in settings:
            lines.append(_with_comment(f"{key}: {_flow(settings[key])}", comments.get(key)))
    lines.append("dofs:  # velocity: per second, of an action of 1; group: kind of joint")
    for dof in settings["dofs"]:
        lines.append(_with_comment(f"  - {_flow(dof)}", comments.get(dof["name"])))
    for key in ("drive", "camera", "hierarchy"):
        if key in settings:
            lines.append(_with_comment(f"{key}: {_flow(settings[key])}", comments.get(key)))
    if "start" in settings:
        lines.append(_with_comment("start:", comments.get("start", "away from the stops")))
        lines += [f"  {_flow(name)}: {_flow(value)}" for name, value in settings["start"].items()]
    if "passing" in settings:
        lines.append("passing:  # pairs whose hulls overlap; share of the random poses")
        for a, b in settings["passing"]:
            lines.append(_with_comment(f"  - {_flow([a, b])}", comments.get(f"{a} {b}")))
    return "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, float):
        return repr(value)
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10_000)
    return text.removesuffix("\n").removesuffix("\n...").strip()


def _with_comment(line: str, comment: str | None) -> str:
    return f"{line}  # {comment}" if comment else line
