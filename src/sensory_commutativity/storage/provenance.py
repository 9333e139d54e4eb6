"""The code, platform and packages that produced a file."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import subprocess
from functools import cache
from pathlib import Path

PACKAGES = (
    "sensory-commutativity", "numpy", "pymunk", "numba", "scipy", "statsmodels", "torch", "pandas",
    "pyarrow", "gymnasium", "stable-baselines3", "sb3-contrib", "pybullet", "torchvision", "h5py",
    "trimesh", "fast-simplification", "matplotlib", "pillow",
)  # fmt: skip


@cache
def git_commit() -> str:
    """Commit of the code.

    It ends with ``-dirty`` if code or configuration have uncommitted changes, and is ``unknown``
    outside a repository.
    """
    root = Path(__file__).resolve().parents[3]

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(root), *arguments]
        run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
        return run.stdout.strip()

    try:
        if Path(git("rev-parse", "--show-toplevel")).resolve() != root:
            return "unknown"  # installed inside another project's repository
        changed = git("status", "--porcelain", "--", "src", "workflow", "config")
        return git("rev-parse", "HEAD") + ("-dirty" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return "unknown"


@cache
def package_versions() -> dict[str, str]:
    """Version of each of PACKAGES; ``absent`` for packages that are not installed."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[package] = "absent"
    return versions


def environment() -> dict[str, str]:
    """Git commit, Python version, platform and package versions (JSON)."""
    return {
        "git_commit": git_commit(),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "packages": json.dumps(package_versions(), sort_keys=True),
    }
