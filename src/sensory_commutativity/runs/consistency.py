"""Does a run belong together: one configuration, one code, and nothing that contradicts the rest?

A run of whole files can still be wrong: with a table of half the seeds, a figure drawn from other
tables, or a report that was made before them. Checked are

- the provenance of all files: one profile, root seed, configuration and commit;
- every file against the settings of the run: is it complete, and computed with them;
- what every file says it was computed from against the files that are there;
- every figure against one redrawn from the tables (:mod:`.redraw`);
- the pictures in the report against the figures.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ..errors import UserError
from ..storage.files import printable
from ..storage.hashing import sha256
from ..studies.checks import SETTINGS, check_complete, check_origin, check_shard
from ..studies.config import Config
from ..studies.declarations import Arrays, Model, Product, Shard, Table
from ..studies.loading import load
from ..studies.provenance import INPUTS
from ..studies.registry import configured
from .checksums import GROUPS, MANIFEST, read_manifest
from .entries import find_link, list_files
from .origin import read_own_origin
from .report import REPORT, read_pictures

SETTINGS_FILE = "config.yaml"


class Contradiction(NamedTuple):
    """Something in a run that contradicts the rest: a path relative to its folder, and what."""

    path: str
    reason: str


class Consistency(NamedTuple):
    """Result of :func:`check_consistency`.

    Attributes
    ----------
    contradictions : tuple of Contradiction
    notes : tuple of str
        Why the run may not be clean although nothing contradicts: what could not be checked, and
        code with uncommitted changes.
    """

    contradictions: tuple[Contradiction, ...]
    notes: tuple[str, ...]

    @property
    def is_clean(self) -> bool:
        """Whether all files come from one configuration and one commit, as far as can be told."""
        return not self.contradictions and not self.notes


def check_consistency(run: Path, redraw: bool = True) -> Consistency:
    """Check that the files of a run belong together.

    Parameters
    ----------
    run : Path
    redraw : bool
        Whether to draw every figure again, which takes about two seconds each.
    """
    names = [name for name in list_files(run) if find_link(run, name) is None]
    origins = _read_origins(run, names)
    found = list(_find_mixtures(run, origins))
    notes = list(_describe_origins(names, origins))
    config, note = load_settings(run)
    notes += [note] if note else []
    found += _find_wrong_inputs(run, origins)
    if config is not None:
        found += _find_wrong_files(run, config, origins)
        if redraw:
            from .redraw import find_stale_figures  # imports matplotlib

            stale, more = find_stale_figures(run, config, set(names))
            found += [Contradiction(*one) for one in stale]
            notes += more
    found += _find_stale_report(run, names, {Path(one.path).name for one in found})
    return Consistency(tuple(found), tuple(notes))


def load_settings(run: Path) -> tuple[Config | None, str]:
    """The settings of a run, and a note if they are not its own.

    Settings that an earlier version wrote are replaced by those that this version has for the
    profile of the same name, so that figures can be drawn again.
    """
    from ..data import data_file

    path = run / SETTINGS_FILE
    if path.is_symlink() or not path.exists():
        return None, f"{SETTINGS_FILE} is missing, so neither settings nor figures are checked"
    try:
        return load(path), ""
    except UserError as error:
        problem = str(error)
    try:
        profile = read_profile(path)
        layers = [data_file("config", name) for name in ("config.yaml", f"{profile}.yaml")]
        config = load(*(layers if profile != "default" else layers[:1]))
    except UserError:
        return None, f"{SETTINGS_FILE} cannot be used: {problem}"
    return config, (
        f"{SETTINGS_FILE} was written by another version ({problem}); checked with this "
        f"version's settings of the profile {profile}"
    )


def read_profile(path: Path) -> str:
    """The name of the profile in settings that cannot be used otherwise. Raises UserError."""
    from ..storage.yamlfile import read_yaml

    content = read_yaml(path, UserError, "the settings of a run")
    profile = content.get("profile") if isinstance(content, dict) else None
    if not isinstance(profile, str) or not profile.replace("-", "").isalnum():
        raise UserError(f"{path}: names no profile; run the workflow again")
    return profile


def _read_origins(run: Path, names: list[str]) -> dict[str, dict[str, str]]:
    """Provenance of all files that carry it."""
    origins = {}
    for name in names:
        try:
            origins[name] = read_own_origin(run / name)
        except UserError:
            continue
    return origins


def _find_mixtures(run: Path, origins: dict[str, dict[str, str]]) -> Iterator[Contradiction]:
    """Keys of the provenance in which the files differ from each other or from the checksums."""
    recorded = {} if (run / MANIFEST).is_symlink() else read_manifest(run / MANIFEST).groups
    for key in GROUPS:
        counts = Counter(origin[key] for origin in origins.values() if key in origin)
        if len(counts) > 1:
            shown = [f"{printable(value):.20} ({n})" for value, n in counts.most_common(12)]
            yield Contradiction(
                ".", f"files of {len(counts)} different {key}, not of one run: {', '.join(shown)}"
            )
        known = recorded.get(key)
        for value in counts if known else ():
            if known and value not in known:
                yield Contradiction(
                    MANIFEST,
                    f"was written before {counts[value]} files of the {key} {printable(value):.20}",
                )


def _describe_origins(names: list[str], origins: dict[str, dict[str, str]]) -> Iterator[str]:
    dirty = sum(origin.get("git_commit", "").endswith("-dirty") for origin in origins.values())
    if dirty:
        yield f"{dirty} files were made by code with uncommitted changes"
    silent = [name for name in names if name not in origins]
    if silent:
        yield f"{len(silent)} files carry no provenance, such as {printable(silent[0])}"


def _find_wrong_inputs(run: Path, origins: dict[str, dict[str, str]]) -> Iterator[Contradiction]:
    """Files that were computed from other contents than those that are there."""
    for name, origin in origins.items():
        for source, recorded in _read_inputs(origin).items():
            if find_link(run, source) is not None or not (run / source).is_file():
                continue
            if _content_hash(run / source, origins.get(source, {})) != recorded:
                yield Contradiction(
                    name, f"was computed from another {printable(source)} than is there"
                )


def _read_inputs(origin: dict[str, str]) -> dict[str, str]:
    try:
        inputs = json.loads(origin.get(INPUTS, "{}"))
    except ValueError:
        return {}
    pairs = inputs.items() if isinstance(inputs, dict) else ()
    return {key: value for key, value in pairs if ".." not in key and isinstance(value, str)}


def _content_hash(path: Path, origin: dict[str, str]) -> str:
    """The hash by which what was computed from a file knows it."""
    return origin.get("rows_sha256", "") if path.suffix == ".parquet" else sha256(path)


def _find_wrong_files(
    run: Path, config: Config, origins: dict[str, dict[str, str]]
) -> Iterator[Contradiction]:
    """Files that are incomplete, or were computed with other settings than the run has."""
    kinds: tuple[type[Table] | type[Arrays] | type[Model], ...] = (Table, Arrays, Model)
    for kind in kinds:
        for product in configured(kind, config, optional=True).values():
            for shard in _shards(product, config, origins):
                name = str(product.file(shard))
                if name not in origins:
                    continue
                problem = _find_problem(product, config, shard, run / name, origins[name])
                if problem:
                    yield Contradiction(name, problem)


def _shards(product: Product, config: Config, names: Iterable[str]) -> list[Shard | None]:
    """What may have a file of its own among `names`: all of a product, and every shard.

    Shards are listed only if there is a file of one, as listing them may take a second.
    """
    shards: list[Shard | None] = []
    if product.shards is None or isinstance(product, Table):
        shards.append(None)
    if product.shards is not None:
        folder = product.file(Shard("any", 0, 0)).parent
        if any(PurePosixPath(name).parent == folder for name in names):
            shards += product.shards.all(config)
    return shards


def _find_problem(
    product: Product, config: Config, shard: Shard | None, path: Path, origin: dict[str, str]
) -> str:
    from ..storage.tables import read_table

    try:
        if SETTINGS in origin:  # earlier versions did not record it
            check_origin(origin, product, config, shard, path)
        if isinstance(product, Table):
            frame = read_table(path, product.name, product.columns, require_hash=False)
            if shard is None:
                check_complete(frame, product, config, path)
            else:
                check_shard(frame, product, config, shard, path)
    except UserError as error:
        return str(error).removeprefix(f"{path}: ")
    return ""


def _find_stale_report(run: Path, names: list[str], wrong: set[str]) -> Iterator[Contradiction]:
    """Pictures of a report that are not the figures of the run, or are among those that are wrong.

    `wrong` holds the names of files that contradict the run.
    """
    path = run / REPORT
    if path.is_symlink() or not path.is_file():
        return
    figures = {Path(name).name: name for name in names if name.startswith("figures/")}
    other, unknown, stale = [], [], []
    for name, data in read_pictures(path).items():
        if name not in figures:
            unknown.append(name)
        elif (run / figures[name]).read_bytes() != data:
            other.append(name)
        elif name in wrong:
            stale.append(name)
    for found, problem in (
        (other, "shows others than the figures that are there"),
        (unknown, "shows figures that are not there"),
        (stale, "shows figures that contradict their tables"),
    ):
        if found:
            more = f" and {len(found) - 3} more" if len(found) > 3 else ""
            yield Contradiction(REPORT, f"{problem}: {', '.join(sorted(found)[:3])}{more}")
