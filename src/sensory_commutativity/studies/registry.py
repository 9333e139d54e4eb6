"""All declarations, found by the names of their modules in the folders of STUDIES."""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from .. import __version__
from ..errors import UserError
from ..storage.hashing import digest
from .config import Config
from .declarations import Animation, Arrays, Figure, Model, Product, Shard, Table

STUDIES = (
    "flatland", "apartment", "objects", "navigation", "paper", "reset_free", "atlas", "gallery",
    "calibration",
)  # fmt: skip
OPTIONAL = ("atlas", "gallery", "calibration")
"""Studies that are run by a target of their own."""
LEFT_OUT_BY_NULL = ("reset_free",)
"""Studies that a configuration may leave out, by a section that is null."""
KINDS: dict[type[Product], str] = {
    Table: "table", Arrays: "arrays", Model: "model", Figure: "figure", Animation: "animation"
}  # fmt: skip
P = TypeVar("P", bound=Product)


@cache
def _modules(folder: str) -> dict[str, str]:
    """Module name -> study, of all modules in ``studies/STUDY/FOLDER/``, in order."""
    root = Path(__file__).parent
    return {
        module.name: study
        for study in STUDIES
        for module in pkgutil.iter_modules([str(root / study / folder)])
    }


@cache
def _load(folder: str, name: str) -> Product:
    module = f".{_modules(folder)[name]}.{folder}.{name}"
    return getattr(importlib.import_module(module, __package__), name)


def declarations(kind: type[P], optional: bool = False) -> dict[str, P]:
    """All declarations of a kind by name: :class:`.Table`, :class:`.Arrays`, :class:`.Model`,
    :class:`.Figure` or :class:`.Animation`; with those of OPTIONAL studies if asked for."""
    folders = ("figures",) if kind in (Figure, Animation) else ("tables", "arrays", "models")
    found = {
        name: _load(folder, name)
        for folder in folders
        for name, study in _modules(folder).items()
        if optional or study not in OPTIONAL
    }
    return {name: product for name, product in found.items() if isinstance(product, kind)}


def configured(kind: type[P], config: Config, optional: bool = False) -> dict[str, P]:
    """As :func:`declarations`, without studies that the configuration leaves out."""
    folders = ("figures",) if kind in (Figure, Animation) else ("tables", "arrays", "models")
    left_out = {study for study in LEFT_OUT_BY_NULL if getattr(config, study) is None}
    names = {
        name for folder in folders for name, study in _modules(folder).items()
        if study in left_out
    }  # fmt: skip
    return {name: one for name, one in declarations(kind, optional).items() if name not in names}


def table_names() -> tuple[str, ...]:
    """Names of all tables, study by study."""
    return tuple(_modules("tables"))


def find(kind: type[P], name: str) -> P:
    """The declaration of this kind and name. Raises UserError with names that are close."""
    folders = ("figures",) if kind in (Figure, Animation) else ("tables", "arrays", "models")
    for folder in folders:
        if name in _modules(folder):
            product = _load(folder, name)
            if isinstance(product, kind):
                return product
    close = difflib.get_close_matches(name, declarations(kind, optional=True), 3)
    kind_name = KINDS[kind]
    hint = f"did you mean {' or '.join(close)}?" if close else "the option --list shows all names"
    raise UserError(f"there is no {kind_name} {name!r}; {hint}")


def find_table(name: str) -> Table:
    """The declaration of the table `name`. Raises UserError."""
    return find(Table, name)


def find_product(name: str) -> Product:
    """The table, arrays or model of this name, or else the animation. Raises LookupError.

    A figure may have the name of the table that it shows: use :func:`find` for figures.
    """
    for folder in ("tables", "arrays", "models", "figures"):
        if name in _modules(folder):
            return _load(folder, name)
    raise LookupError(f"nothing of the name {name!r} is declared")


def find_input(specification: str) -> tuple[Product, str | None, str | None]:
    """What an input names: the product, and the run and the part if it names one.

    The forms are ``NAME``, ``NAME/RUN`` and ``NAME/RUN:PART``.
    """
    name, _, run = specification.partition("/")
    run, _, part = run.partition(":")
    return find_product(name), run or None, part or None


def input_shards(
    product: Product, config: Config, shard: Shard | None
) -> list[tuple[Product, list[Shard | None]]]:
    """What `product`, or a shard of it, is computed from.

    Returns
    -------
    list
        For every input its declaration, and the shards that are read; ``[None]`` for a file that
        holds all of it.
    """
    found: list[tuple[Product, list[Shard | None]]] = []
    for specification in product.input_names(config, shard.run if shard else None):
        if shard is not None:
            specification = specification.replace("{part}", shard.part)
        source, run, part = find_input(specification)
        shards: list[Shard | None] = [None]
        whole = isinstance(source, Table) and not source.shards_only
        if source.shards is not None and (run is not None or not whole):
            chosen = source.shards.of_run(config, run) if run else source.shards.all(config)
            shards = [one for one in chosen if part is None or one.part == part]
        found.append((source, shards))
    return found


_digests: dict[int, tuple[Config, dict[tuple[str, str, str | None], str]]] = {}
"""Identity of a configuration -> the configuration, and the digests of products and runs."""


def settings_digest(product: Product, config: Config, run: str | None = None) -> str:
    """Hash of everything that determines a product, or the units of one of its runs.

    That is the version of the package, the root seed, its own settings, and all of that for its
    inputs. How work is cut into jobs is not part of it.
    """
    _, known = _digests.setdefault(id(config), (config, {}))
    key = (KINDS[type(product)], product.name, run)  # a figure may have the name of its table
    if key not in known:
        known[key] = _settings_digest(product, config, run)
    return known[key]


def _settings_digest(product: Product, config: Config, run: str | None) -> str:
    kind = KINDS[type(product)]
    own: list[Any] = [__version__, config.seed, kind, product.name, product.settings(config)]
    if product.shards is not None and run is None:
        runs = product.shards.runs(config)
        return digest(*own, [[r, n, settings_digest(product, config, r)] for r, n in runs.items()])
    if product.shards is not None and run is not None:
        own += [run, product.shards.settings(config, run)]
    inputs: list[Any] = []
    for specification in product.input_names(config, run):
        source, source_run, _ = find_input(specification)
        inputs.append(settings_digest(source, config, source_run))
        if source.shards is not None and source_run is not None:
            inputs.append(source.shards.runs(config)[source_run])
    return digest(*own, inputs)
