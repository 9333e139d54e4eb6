"""Where a result comes from: recorded in every table."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import subprocess
from functools import lru_cache
from pathlib import Path

from ..studies.config import Config

PACKAGES = (
    "sensory-commutativity", "numpy", "pymunk", "numba", "scipy", "statsmodels", "torch", "pandas", "pyarrow",
    "gymnasium", "stable-baselines3", "sb3-contrib", "pybullet", "torchvision", "h5py", "trimesh", "fast-simplification",
)  # fmt: skip


@lru_cache
def _git_commit() -> str:
    """The commit of the code, with ``-dirty`` when the code or the config differs from it; ``unknown`` outside a repository."""
    here = Path(__file__).resolve().parents[2]

    def git(*arguments: str) -> str:
        return subprocess.run(
            ["git", "-C", str(here), *arguments],
            capture_output=True,
            text=True,
            check=True,
            timeout=10,
        ).stdout.strip()

    try:
        if Path(git("rev-parse", "--show-toplevel")).resolve() != here:
            return "unknown"  # installed inside somebody else's repository
        changed = git("status", "--porcelain", "--", "src", "workflow", "config", "Snakefile")
        return git("rev-parse", "HEAD") + ("-dirty" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return "unknown"


@lru_cache
def package_versions() -> dict[str, str]:
    """Version of each of PACKAGES; ``absent`` where one is not installed."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[package] = "absent"
    return versions


def provenance(config: Config) -> dict[str, str]:
    """Config hash, root seed, git commit, platform and package versions; of the run that wrote a table."""
    return {
        "profile": config.profile,
        "config_sha256": config.digest(),
        "root_seed": str(config.seed),
        "git_commit": _git_commit(),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "packages": json.dumps(package_versions(), sort_keys=True),
    }
