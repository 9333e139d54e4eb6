"""The modules of docs/_generate, which belong to no package."""

from __future__ import annotations

import importlib
import sys

from tests.helpers import ROOT

sys.path.insert(0, str(ROOT / "docs" / "_generate"))
hook = importlib.import_module("hook")
links = importlib.import_module("links")
notebooks = importlib.import_module("notebooks")
reference = importlib.import_module("reference")
results = importlib.import_module("results")
run_notebooks = importlib.import_module("run_notebooks")
sys.path.remove(str(ROOT / "docs" / "_generate"))
