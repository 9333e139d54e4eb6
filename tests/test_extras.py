"""Optional packages: what is imported when, and what is said if one is missing."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import sensory_commutativity
from sensory_commutativity import MissingExtraError
from sensory_commutativity.data import data_file
from sensory_commutativity.errors import UserError
from sensory_commutativity.extras import EXTRAS, extra_needed
from tests.helpers import ROOT


def run_without(modules: str, code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run `code` in a Python that cannot import `modules`."""
    hidden = f"import sys\nfor name in {modules.split()!r}:\n    sys.modules[name] = None\n"
    return subprocess.run(
        [sys.executable, "-c", hidden + code], cwd=folder, capture_output=True, text=True
    )


OPTIONAL = " ".join(module for modules in EXTRAS.values() for module in modules)


def test_the_first_example_needs_no_extra(tmp_path: Path) -> None:
    code = (
        "from sensory_commutativity import Corridor, measure\n"
        "scp = measure(Corridor(wall=3), n=50, length=5)\n"
        "print(scp, scp.order())\n"
        "scp.save('scp.parquet'), scp.plot().figure.savefig('scp.png')\n"
    )
    run = run_without(OPTIONAL, code, tmp_path)
    assert run.returncode == 0, run.stderr
    assert "SCP of Corridor" in run.stdout and (tmp_path / "scp.png").exists()


@pytest.mark.parametrize(
    ("command", "extra"),
    [
        ("measure flatland", "flatland"),
        ("measure --robot fetch", "apartment"),
        ("robot init a.urdf", "apartment"),
        ("measure corridor --distance vgg16", "change-detection"),
        ("measure Pendulum-v1", "environments"),
        ("predict a.png b.png", "change-detection"),
        ("config check", "workflow"),
    ],
)
def test_a_missing_extra_is_named(tmp_path: Path, command: str, extra: str) -> None:
    code = f"sys.argv = ['sencom', *{command.split()!r}]\n"
    code += "from sensory_commutativity.cli import entry_point\nentry_point()\n"
    run = run_without(OPTIONAL, code, tmp_path)
    assert run.returncode == 2 and run.stderr.count("\n") == 1, run.stderr
    assert f"pip install 'sensory-commutativity[{extra}]'" in run.stderr


def test_tables_are_listed_and_figures_too_without_any_extra(tmp_path: Path) -> None:
    code = (
        "from sensory_commutativity.studies.declarations import Figure, Table\n"
        "from sensory_commutativity.studies.registry import declarations\n"
        "print(len(declarations(Table)), len(declarations(Figure)))\n"
    )
    run = run_without(OPTIONAL, code, tmp_path)
    assert run.returncode == 0, run.stderr


def test_commands_import_what_they_use() -> None:
    """No command line that only measures a corridor loads what others need."""
    code = (
        "import sys\n"
        "import sensory_commutativity\n"
        "assert not {'numpy', 'pandas', 'click'} & set(sys.modules)\n"
        "from sensory_commutativity.cli import main\n"
        "main(['--help'], standalone_mode=False)\n"
        "assert not {'numpy', 'pandas', 'pydantic'} & set(sys.modules)\n"
        "main(['-q', 'measure', 'corridor', '-n', '5'], standalone_mode=False)\n"
        "slow = 'torch scipy matplotlib statsmodels numba pybullet gymnasium'.split()\n"
        "print('LOADED', *(name for name in slow if name in sys.modules))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1].split() == ["LOADED"]


def test_every_module_of_an_extra_belongs_to_a_package_of_it() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())
    for extra, modules in EXTRAS.items():
        packages = " ".join(declared["project"]["optional-dependencies"][extra])
        for module in modules:
            names = {module.lower(), module.lower().replace("_", "-")}
            assert any(name in packages.lower() for name in names), (extra, module)


def test_modules_that_no_extra_provides_are_not_explained() -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_module"), extra_needed():
        import no_such_module  # noqa: F401
    with pytest.raises(MissingExtraError, match="navigation"), extra_needed("navigation"):
        raise ModuleNotFoundError(name="gymnasium.vector")


def test_every_public_name_can_be_imported() -> None:
    for name in sensory_commutativity.__all__:
        assert getattr(sensory_commutativity, name) is not None
    assert set(sensory_commutativity.__all__) <= set(dir(sensory_commutativity))
    with pytest.raises(AttributeError, match="nothing"):
        sensory_commutativity.nothing  # noqa: B018


def test_files_of_the_package_are_found() -> None:
    for parts in (("config", "config.yaml"), ("config", "robots", "fetch.yaml"),
                  ("predictors", "raft.predictor")):  # fmt: skip
        assert data_file(*parts).is_file()
    with pytest.raises(UserError, match="nothing"):
        data_file("config", "nothing.yaml")
