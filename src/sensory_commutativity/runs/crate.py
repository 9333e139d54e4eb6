"""A finished run as one ZIP file for an archive: a Workflow Run RO-Crate.

It describes in a standard vocabulary which workflow was run, on which settings, and what resulted.
Profile: https://w3id.org/ro/wfrun/workflow/0.5
"""

from __future__ import annotations

import datetime
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import UserError
from ..storage.atomic import atomic_write
from ..storage.files import printable
from ..storage.hashing import sha256
from ..storage.yamlfile import read_yaml
from .checksums import MANIFEST, read_manifest
from .compare import find_tables_folder
from .entries import list_files, list_irregular
from .origin import OriginError, read_origin

if TYPE_CHECKING:
    from rocrate.model.contextentity import ContextEntity
    from rocrate.rocrate import ROCrate

ROOT = Path(__file__).resolve().parents[3]
SNAKEFILE = "workflow/Snakefile"
WORKFLOW_FOLDERS = {
    "workflow": "rules and captions of the workflow",
    "config": "configurations of the workflow, and the robots and apartments that they name",
    "src": "the Python package that the rules call",
}
"""Folders that the Snakefile needs, with descriptions."""
ROOT_FILES = ("README.md", "LICENSE", "CITATION.cff", "pyproject.toml", "requirements.lock")
ROCRATE_VERSION = "1.1"
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
MEDIA_TYPES = {
    ".parquet": "application/vnd.apache.parquet",
    ".h5": "application/x-hdf5",
    ".json": "application/json",
    ".png": "image/png",
    ".gif": "image/gif",
    ".pdf": "application/pdf",
    ".html": "text/html",
    ".md": "text/markdown",
    ".yaml": "application/yaml",
    ".cff": "application/yaml",
    ".toml": "application/toml",
    ".predictor": "application/octet-stream",
    ".policy": "application/octet-stream",
}
"""Suffix -> media type; plain text for all others."""
COMPRESSED = (".parquet", ".h5", ".predictor", ".policy", ".png", ".gif", ".pdf")
"""Suffixes of files that are not worth compressing again."""


def write_crate(
    run: Path, out: Path, with_data: bool = False, date: datetime.date | None = None
) -> int:
    """Write a run as a ZIP file.

    Parameters
    ----------
    run, out : Path
    with_data : bool
        Whether to include the raw data, which no figure needs.
    date : datetime.date, optional
        Date of publication; today by default.

    Returns
    -------
    int
        Number of files in the crate.

    Raises
    ------
    UserError
        If the folder is not a run, or a file is damaged.
    """
    from rocrate.rocrate import ROCrate

    if not (ROOT / SNAKEFILE).is_file():
        raise UserError(
            f"{ROOT / SNAKEFILE}: there is no such file, so the crate would lack the workflow; "
            "install the package from a clone (make)"
        )
    _check_links(run)
    settings = _read_settings(run)
    files: dict[str, Path] = {}  # path in the crate -> file
    crate = ROCrate(version=ROCRATE_VERSION)
    crate.metadata.extra_terms = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
    crate.root_dataset["datePublished"] = (date or datetime.date.today()).isoformat()
    workflow = _add_workflow(crate, files)
    title = f"the run {settings['profile']!r}"
    crate.name = f"{workflow['name']}: {title}"
    crate.description = (
        f"Settings, tables, models and figures of {title} of the workflow, and the workflow itself."
    )
    config, results = _add_run_files(crate, files, run, settings["profile"], with_data)
    _add_action(crate, run, settings["profile"], workflow, config, results)
    metadata = json.dumps(crate.metadata.generate(), indent=2, ensure_ascii=False).encode()
    with atomic_write(out) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for folder in WORKFLOW_FOLDERS:
            _write_entry(archive, f"{folder}/", b"")  # the metadata describe it, so it must exist
        for name, path in files.items():
            _write_entry(archive, name, path.read_bytes())
        _write_entry(archive, "ro-crate-metadata.json", metadata)
    return len(files) + 1


def _check_links(run: Path) -> None:
    """Raise UserError if something in a run leads out of it."""
    links = [name for name in ("config.yaml", MANIFEST, "report.html") if (run / name).is_symlink()]
    for name, kind in {**list_irregular(run), **dict.fromkeys(links, "a link")}.items():
        raise UserError(
            f"{run / printable(name)}: is {kind}, and a crate holds files of the run alone; "
            "put what it stands for in its place, or delete it"
        )


def _read_settings(run: Path) -> dict[str, Any]:
    """Read the settings of a run. Raises UserError if there are none."""
    find_tables_folder(run)
    try:
        settings = read_yaml(run / "config.yaml", UserError, "the settings of a run")
    except UserError:
        settings = None
    if not isinstance(settings, dict) or not re.fullmatch(
        r"[\w.-]+", str(settings.get("profile", ""))
    ):
        raise UserError(
            f"{run / 'config.yaml'}: missing or not the settings of a run; "
            "run the workflow again, or give another folder"
        )
    return settings


def _add_run_files(
    crate: ROCrate, files: dict[str, Path], run: Path, profile: str, with_data: bool
) -> tuple[Any, list[Any]]:
    """Add the settings and results of a run; return the entities of both."""

    def add(name: str, description: str, **properties: Any) -> Any:
        path = f"results/{profile}/{name}"
        return _add_file(crate, files, run / name, path, description=description, **properties)

    config = add("config.yaml", "all settings of the run")
    for name, description in (
        (MANIFEST, "SHA-256 of the results of the run"),
        ("report.html", "the figures with explanations"),
    ):
        if (run / name).is_file():
            add(name, description)
    names = [name for name in list_files(run) if with_data or not name.startswith("data/")]
    return config, [add(name, _describe(name), sha256=h) for name, h in _hash_files(run, names)]


def _hash_files(run: Path, names: list[str]) -> Iterator[tuple[str, str]]:
    """Yield name and SHA-256 of each file. Raises UserError if it is not its checksum."""
    recorded = read_manifest(run / MANIFEST).hashes
    for name in names:
        file_hash = sha256(run / name)
        if recorded.get(name, file_hash) != file_hash:
            raise UserError(
                f"{run / name}: does not have its checksum in {run / MANIFEST}; "
                f"see sensory-commutativity run verify {run}"
            )
        yield name, file_hash


def _describe(name: str) -> str:
    kinds = {"data": "raw data", "models": "model", "tables": "table", "figures": "figure"}
    return f"{kinds[name.split('/')[0]]} {Path(name).stem}"


def _add_file(
    crate: ROCrate, files: dict[str, Path], path: Path, name: str, **properties: Any
) -> Any:
    """Add a file to the metadata and to `files`; return its entity."""
    files[name] = path
    basic = {
        "name": path.name,
        "encodingFormat": MEDIA_TYPES.get(path.suffix, "text/plain"),
        "contentSize": str(path.stat().st_size),
    }
    return crate.add_file(path, name, properties={**basic, **properties})


def _add_workflow(crate: ROCrate, files: dict[str, Path]) -> Any:
    """Add the workflow of this clone with licence and authors; return its entity."""
    from rocrate.model.contextentity import ContextEntity

    citation = read_yaml(ROOT / "CITATION.cff", UserError, "CITATION.cff")
    licence_name = (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()[0]
    licence_url = f"https://spdx.org/licenses/{citation['license']}"
    properties = {"@type": "CreativeWork", "name": licence_name}
    licence = crate.add(ContextEntity(crate, licence_url, properties))
    authors = [
        crate.add(ContextEntity(crate, *_describe_author(author))) for author in citation["authors"]
    ]
    files[SNAKEFILE] = ROOT / SNAKEFILE
    properties = {"name": citation["title"], "version": __version__, "encodingFormat": "text/plain"}
    workflow = crate.add_workflow(
        ROOT / SNAKEFILE, SNAKEFILE, main=True, lang="snakemake", properties=properties
    )
    workflow["license"] = crate.root_dataset["license"] = licence
    workflow["author"] = crate.root_dataset["author"] = authors if len(authors) > 1 else authors[0]
    for profile, name in PROFILES.items():
        properties = {"@type": "CreativeWork", "name": name, "version": profile.rsplit("/", 1)[1]}
        profile_entity = crate.add(ContextEntity(crate, profile, properties))
        crate.root_dataset.append_to("conformsTo", profile_entity)
    for name in ROOT_FILES:
        if (ROOT / name).is_file():
            about = {"about": crate.root_dataset} if name == "README.md" else {}
            _add_file(crate, files, ROOT / name, name, **about)
    for folder, description in WORKFLOW_FOLDERS.items():
        properties = {"name": folder, "description": description}
        dataset = crate.add_dataset(ROOT / folder, folder, properties=properties)
        workflow.append_to("hasPart", dataset)
        files.update(_list_source_files(folder))
    return workflow


def _list_source_files(folder: str) -> dict[str, Path]:
    """Files of a folder of the clone by relative path, without hidden and generated ones."""
    files = {}
    for path in sorted((ROOT / folder).rglob("*")):
        relative = path.relative_to(ROOT)
        if (
            path.is_file()
            and not path.is_symlink()
            and not any(
                part.startswith(".") or part.endswith(("__pycache__", ".egg-info"))
                for part in relative.parts
            )
        ):
            files[relative.as_posix()] = path
    return files


def _describe_author(author: dict[str, str]) -> tuple[str, dict[str, str]]:
    """Id and properties of an author in CITATION.cff; an organisation has a single name."""
    is_person = "family-names" in author
    if is_person:
        name = f"{author.get('given-names', '')} {author['family-names']}".strip()
    else:
        name = author["name"]
    anchor = f"#{re.sub(r'[^a-z0-9]+', '-', name.lower())}"
    identifier = author.get("orcid") or author.get("website") or anchor
    return identifier, {"@type": "Person" if is_person else "Organization", "name": name}


def _add_action(
    crate: ROCrate, run: Path, profile: str, workflow: Any, config: Any, results: list[Any]
) -> None:
    """Add the run itself: instrument, inputs, results and environment."""
    from rocrate.model.contextentity import ContextEntity

    origins = _read_origins(run)
    if not origins:
        raise UserError(f"{run}: none of its tables carries provenance; run the workflow again")

    def add_values(key: str, description: str) -> list[ContextEntity]:
        # There are several where a run was continued with another version of the code.
        values = dict.fromkeys(origin[key] for origin in origins if key in origin)
        properties = {"@type": "PropertyValue", "name": key, "description": description}
        return [
            crate.add(ContextEntity(crate, f"#{key}{i or ''}", {**properties, "value": value}))
            for i, value in enumerate(values)
        ]

    _add_packages(crate, workflow, origins)
    properties = {
        "@type": "CreateAction",
        "name": f"the run {profile!r}",
        "description": "Snakemake computed the tables, models and figures in "
        f"results/{profile} from its config.yaml.",
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }
    if (run / "data").is_dir():  # elsewhere the files are copies with other times
        latest = max((run / name).stat().st_mtime for name in list_files(run))
        end = datetime.datetime.fromtimestamp(int(latest), datetime.UTC)
        properties["endTime"] = end.isoformat()
    action = crate.add(ContextEntity(crate, "#run", properties))
    action["instrument"] = workflow
    action["object"] = [config, *add_values("root_seed", "everything random follows from it")]
    action["result"] = results
    commit = (
        "commit of the code that ran; the workflow in this crate is that of the clone from which "
        "the crate was made"
    )
    action["additionalProperty"] = [
        *add_values("config_sha256", "SHA-256 of the settings"),
        *add_values("git_commit", commit),
        *add_values("python", "version of Python"),
        *add_values("platform", "operating system and processor"),
    ]
    crate.root_dataset["mentions"] = action


def _add_packages(crate: ROCrate, workflow: Any, origins: list[dict[str, str]]) -> None:
    """Add the packages that computed the tables as requirements of the workflow."""
    from rocrate.model.contextentity import ContextEntity

    packages = {
        package
        for origin in origins
        for package in json.loads(origin.get("packages", "{}")).items()
    }
    for name, version in sorted(packages):
        if version == "absent":
            continue
        url = f"https://pypi.org/project/{name}/{version}/"
        properties = {"@type": "SoftwareApplication", "name": name, "version": version, "url": url}
        workflow.append_to("softwareRequirements", crate.add(ContextEntity(crate, url, properties)))


def _read_origins(run: Path) -> list[dict[str, str]]:
    """Provenance of all tables that carry it."""
    origins = []
    for path in sorted(find_tables_folder(run).glob("*.parquet")):
        try:
            origins.append(read_origin(path))
        except OriginError:
            continue
    return origins


def _write_entry(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    """Add a file without its time, so that equal runs give equal crates."""
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (0o40755 << 16) | 0x10 if name.endswith("/") else 0o644 << 16
    entry.compress_type = zipfile.ZIP_STORED if name.endswith(COMPRESSED) else zipfile.ZIP_DEFLATED
    archive.writestr(entry, data)
