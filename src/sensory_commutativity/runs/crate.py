"""A finished run as one file for an archive: a Workflow Run RO-Crate, which says in terms that others know what was run, on what, and what came out.

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
from ..storage.yamlfile import read_yaml
from .checksums import MANIFEST, files_of, read_manifest, sha256
from .compare import tables_of
from .origin import OriginError, origin_of

if TYPE_CHECKING:
    from rocrate.model.contextentity import ContextEntity
    from rocrate.rocrate import ROCrate

ROOT = Path(__file__).resolve().parents[3]
SNAKEFILE = "Snakefile"
WORKFLOW = {
    "workflow": "rules and captions of the workflow",
    "config": "configurations of the workflow, and the robots and apartments that they name",
    "src": "the Python package that the rules call",
}
"""Folders beside the Snakefile that it needs."""
BESIDE = ("README.md", "LICENSE", "CITATION.cff", "pyproject.toml", "requirements.lock")
ROCRATE, WROC, WFRUN = (
    "1.1",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0",
    "https://w3id.org/ro/wfrun",
)
PROFILES = {
    f"{WFRUN}/process/0.5": "Process Run Crate",
    f"{WFRUN}/workflow/0.5": "Workflow Run Crate",
    WROC: "Workflow RO-Crate",
}
FORMATS = {
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
"""How files are written that end so; all others are plain text."""
COMPRESSED = (".parquet", ".h5", ".predictor", ".policy", ".png", ".gif", ".pdf")


def write_crate(
    run: Path, out: Path, with_data: bool = False, date: datetime.date | None = None
) -> int:
    """Write the run as a ZIP file; return how many files it holds. Raises UserError for a folder that is no run, and for damaged files.

    Parameters
    ----------
    run, out : Path
    with_data : bool
        Whether the raw data go in, which no figure needs.
    date : datetime.date, optional
        When the crate is published; today if it is not given.
    """
    from rocrate.rocrate import ROCrate

    if not (ROOT / SNAKEFILE).is_file():
        raise UserError(
            f"{ROOT / SNAKEFILE}: there is no such file, so the crate would lack the workflow; install the package from a clone (make)"
        )
    settings = _settings(run)
    inside: dict[str, Path] = {}  # path in the crate -> file
    crate = ROCrate(version=ROCRATE)
    crate.metadata.extra_terms = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
    crate.root_dataset["datePublished"] = (date or datetime.date.today()).isoformat()
    workflow = _workflow(crate, inside)
    where = f"results/{settings['profile']}"

    def add(name: str, text: str, **more: Any):
        return _file(crate, inside, run / name, f"{where}/{name}", description=text, **more)

    given = add("config.yaml", "all settings of the run")
    for name, text in (
        (MANIFEST, "SHA-256 of what the run made"),
        ("report.html", "the figures with explanations"),
    ):
        if (run / name).is_file():
            add(name, text)
    names = [name for name in files_of(run) if with_data or not name.startswith("data/")]
    results = [add(name, _kind(name), sha256=digest) for name, digest in _hashed(run, names)]
    crate.name = f"{workflow['name']}: the run {settings['profile']!r}"
    crate.description = f"Settings, tables, models and figures of the run {settings['profile']!r} of the workflow, and the workflow itself."
    _action(crate, run, settings, workflow, given, results)
    with atomic_write(out) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for folder in WORKFLOW:
            _put(archive, f"{folder}/", b"")  # named in the metadata, so it must be there itself
        for name, path in inside.items():
            _put(archive, name, path.read_bytes())
        _put(
            archive,
            "ro-crate-metadata.json",
            json.dumps(crate.metadata.generate(), indent=2, ensure_ascii=False).encode(),
        )
    return len(inside) + 1


def _settings(run: Path) -> dict[str, Any]:
    """The resolved settings of a run. Raises UserError where there are none."""
    tables_of(run)
    try:
        settings = read_yaml(run / "config.yaml", UserError, "the settings of a run")
    except UserError:
        settings = None
    if not isinstance(settings, dict) or not re.fullmatch(
        r"[\w.-]+", str(settings.get("profile", ""))
    ):
        raise UserError(
            f"{run / 'config.yaml'}: missing or not the settings of a run; run the workflow again, or give another folder"
        )
    return settings


def _hashed(run: Path, names: list[str]) -> Iterator[tuple[str, str]]:
    """Files and their SHA-256. Raises UserError where a file is not what the checksums of the run say."""
    recorded = read_manifest(run / MANIFEST).hashes
    for name in names:
        digest = sha256(run / name)
        if recorded.get(name, digest) != digest:
            raise UserError(
                f"{run / name}: not what {run / MANIFEST} says; see sensory-commutativity verify {run}"
            )
        yield name, digest


def _kind(name: str) -> str:
    kinds = {"data": "raw data", "models": "model", "tables": "table", "figures": "figure"}
    return f"{kinds[name.split('/')[0]]} {Path(name).stem}"


def _file(crate: ROCrate, inside: dict[str, Path], path: Path, name: str, **about: Any):
    """Add a file to the crate, and note that it goes in."""
    inside[name] = path
    known = {
        "name": path.name,
        "encodingFormat": FORMATS.get(path.suffix, "text/plain"),
        "contentSize": str(path.stat().st_size),
    }
    return crate.add_file(path, name, properties={**known, **about})


def _workflow(crate: ROCrate, inside: dict[str, Path]):
    """Add the workflow, as it is here, with its licence and its authors; return its entity."""
    from rocrate.model.contextentity import ContextEntity

    cited = read_yaml(ROOT / "CITATION.cff", UserError, "CITATION.cff")
    text = (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()[0]
    license_ = crate.add(
        ContextEntity(
            crate,
            f"https://spdx.org/licenses/{cited['license']}",
            {"@type": "CreativeWork", "name": text},
        )
    )
    authors = [crate.add(ContextEntity(crate, *_author(author))) for author in cited["authors"]]
    inside[SNAKEFILE] = ROOT / SNAKEFILE
    about = {"name": cited["title"], "version": __version__, "encodingFormat": "text/plain"}
    workflow = crate.add_workflow(
        ROOT / SNAKEFILE, SNAKEFILE, main=True, lang="snakemake", properties=about
    )
    workflow["license"] = crate.root_dataset["license"] = license_
    workflow["author"] = crate.root_dataset["author"] = authors if len(authors) > 1 else authors[0]
    for profile, name in PROFILES.items():
        about = {"@type": "CreativeWork", "name": name, "version": profile.rsplit("/", 1)[1]}
        crate.root_dataset.append_to("conformsTo", crate.add(ContextEntity(crate, profile, about)))
    for name in BESIDE:
        if (ROOT / name).is_file():
            _file(
                crate,
                inside,
                ROOT / name,
                name,
                **({"about": crate.root_dataset} if name == "README.md" else {}),
            )
    for folder, said in WORKFLOW.items():
        workflow.append_to(
            "hasPart",
            crate.add_dataset(
                ROOT / folder, folder, properties={"name": folder, "description": said}
            ),
        )
        for path in sorted((ROOT / folder).rglob("*")):
            below = path.relative_to(ROOT)
            if path.is_file() and not any(
                part.startswith(".") or part.endswith(("__pycache__", ".egg-info"))
                for part in below.parts
            ):
                inside[below.as_posix()] = path
    return workflow


def _author(author: dict[str, str]) -> tuple[str, dict[str, str]]:
    """Id and properties of an author of CITATION.cff: a person or, where it has but a name, an organisation."""
    person = "family-names" in author
    name = (
        f"{author.get('given-names', '')} {author['family-names']}".strip()
        if person
        else author["name"]
    )
    identifier = (
        author.get("orcid")
        or author.get("website")
        or f"#{re.sub(r'[^a-z0-9]+', '-', name.lower())}"
    )
    return identifier, {"@type": "Person" if person else "Organization", "name": name}


def _action(
    crate: ROCrate, run: Path, settings: dict[str, Any], workflow, given, results: list
) -> None:
    """Add that the workflow was run: on what, with what, and what came out."""
    from rocrate.model.contextentity import ContextEntity

    origins = _origins(run)
    if not origins:
        raise UserError(
            f"{run}: none of its tables says where it comes from; run the workflow again"
        )

    def values(key: str, text: str) -> list[ContextEntity]:
        found = dict.fromkeys(
            origin[key] for origin in origins if key in origin
        )  # several, where a run went on with another version
        about = {"@type": "PropertyValue", "name": key, "description": text}
        return [
            crate.add(ContextEntity(crate, f"#{key}{i or ''}", {**about, "value": value}))
            for i, value in enumerate(found)
        ]

    packages = sorted(
        {
            (name, version)
            for origin in origins
            for name, version in json.loads(origin.get("packages", "{}")).items()
        }
    )
    for name, version in packages:
        if version != "absent":
            url = f"https://pypi.org/project/{name}/{version}/"
            about = {"@type": "SoftwareApplication", "name": name, "version": version, "url": url}
            workflow.append_to("softwareRequirements", crate.add(ContextEntity(crate, url, about)))
    about = {
        "@type": "CreateAction",
        "name": f"the run {settings['profile']!r}",
        "description": f"Snakemake made the tables, models and figures below results/{settings['profile']} from its config.yaml.",
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }
    if (run / "data").is_dir():  # elsewhere the files are copies, whose times say nothing
        latest = max((run / name).stat().st_mtime for name in files_of(run))
        about["endTime"] = datetime.datetime.fromtimestamp(int(latest), datetime.UTC).isoformat()
    action = crate.add(ContextEntity(crate, "#run", about))
    action["instrument"] = workflow
    action["object"] = [given, *values("root_seed", "everything random follows from it")]
    action["result"] = results
    action["additionalProperty"] = [
        *values("config_sha256", "SHA-256 of the settings"),
        *values(
            "git_commit",
            "commit of the code that ran; the workflow in this crate is that of the clone from which the crate was made",
        ),
        *values("python", "version of Python"),
        *values("platform", "operating system and processor"),
    ]
    crate.root_dataset["mentions"] = action


def _origins(run: Path) -> list[dict[str, str]]:
    """What the tables say of where they come from, those left out that say nothing."""
    found = []
    for path in sorted(tables_of(run).glob("*.parquet")):
        try:
            found.append(origin_of(path))
        except OriginError:
            continue
    return found


def _put(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    """Add a file without its time of writing, so that the same run gives the same crate."""
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (0o40755 << 16) | 0x10 if name.endswith("/") else 0o644 << 16
    entry.compress_type = zipfile.ZIP_STORED if name.endswith(COMPRESSED) else zipfile.ZIP_DEFLATED
    archive.writestr(entry, data)
