"""Pages of the reference, made from the code when the site is built.

The API comes from the public names and their docstrings, the command line from the program, the
configuration from its models, and tables and figures from their declarations.
"""

from __future__ import annotations

import inspect
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

import click

import sensory_commutativity
from sensory_commutativity.cli import main
from sensory_commutativity.data import data_file
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Animation, Figure, Product, Table
from sensory_commutativity.studies.loading import json_schema, load
from sensory_commutativity.studies.registry import STUDIES, declarations

API_TITLES = {
    "measurement": "Measuring",
    "scp": "Worlds and experiments",
    "adapters": "Environments",
    "worlds": "Worlds of this package",
    "change_detection": "Change detection",
    "navigation": "Action spaces",
}
"""Package -> title of its page; what is in none of them is on the page "Seeds and errors"."""
REST = "Seeds and errors"


def reference_pages() -> dict[str, str]:
    """Path below ``docs/`` -> Markdown, of all pages of the reference but its first."""
    config = load(data_file("config", "config.yaml"))
    return {
        **api_pages(),
        "reference/commands.md": commands_page(),
        "reference/configuration.md": configuration_page(),
        **table_pages(config),
    }


# ---- API --------------------------------------------------------------------------------------


def api_pages() -> dict[str, str]:
    """A page for each package with public names; mkdocstrings fills in the docstrings."""
    groups: dict[str, list[str]] = defaultdict(list)
    for name in sensory_commutativity.__all__:
        if not name.startswith("__"):
            module = sensory_commutativity._MODULE_OF[name]
            title = API_TITLES.get(module.partition(".")[0], REST)
            groups[title].append(f"sensory_commutativity.{module}.{name}")
    order = [*API_TITLES.values(), REST]
    return {
        f"reference/api/{title.lower().replace(' ', '-')}.md": _api_page(title, groups[title])
        for title in order
        if groups[title]
    }


def _api_page(title: str, names: list[str]) -> str:
    short = [name.rpartition(".")[2] for name in names]
    lines = [
        f"# {title}",
        "All of these can be imported from `sensory_commutativity`: "
        + ", ".join(f"[`{one}`][{name}]" for one, name in zip(short, names, strict=True))
        + ".",
        *(f"::: {name}" for name in names),
    ]
    return "\n\n".join(lines) + "\n"


# ---- command line -----------------------------------------------------------------------------


def commands_page() -> str:
    """All commands with their options, as the program itself describes them."""
    lines = [
        "# Command line",
        "`sencom` is short for `sensory-commutativity`. `sencom COMMAND --help` prints what is "
        "below. An error that you can correct is one line and exit code 2.",
    ]
    for path, command in _commands(main, ("sencom",)):
        lines += _command_section(path, command)
    return "\n\n".join(lines) + "\n"


def _commands(
    command: click.Command, path: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            found = command.get_command(context, name)
            if found is not None and not found.hidden:
                yield from _commands(found, (*path, name))


def _command_section(path: tuple[str, ...], command: click.Command) -> list[str]:
    context = click.Context(command, info_name=" ".join(path))
    usage = " ".join([*path, *command.collect_usage_pieces(context)])
    rows = [
        record
        for parameter in command.get_params(context)
        if isinstance(parameter, click.Option)
        and "--help" not in parameter.opts
        and (record := parameter.get_help_record(context)) is not None
    ]
    help_text = inspect.cleandoc(command.help or "").split("\f")[0].replace("\b\n", "\n")
    lines = [f"{'##' if len(path) < 3 else '###'} {' '.join(path)}", f"```text\n{usage}\n```"]
    lines.append(help_text.strip())
    if rows:
        lines.append(_table(("option", "meaning"), [(f"`{name}`", text) for name, text in rows]))
    return [line for line in lines if line]


# ---- configuration ----------------------------------------------------------------------------


def configuration_page() -> str:
    """All keys of the configuration, from its models."""
    schema = json_schema()
    top, sections = [], []
    for key, field in schema["properties"].items():
        section = _object(field, schema)
        if section is None:
            top.append(_key_row(key, field, schema, key in schema.get("required", ())))
        else:
            rows = list(_rows(section, schema, key))
            text = field.get("description") or section.get("description", "")
            sections += [f"## {key}", _escape_text(text), _keys_table(rows)]
    lines = [
        "# Configuration",
        "Every key, as the models of the configuration declare it. `NAME` stands for a name of "
        "your choice, `[]` for each entry of a list. A file that is merged over "
        "`config/config.yaml` needs only the keys that it changes. When to change a key: "
        "[config/README.md](../repository/config/README.md).",
        _keys_table(top),
        *sections,
    ]
    return "\n\n".join(line for line in lines if line) + "\n"


def _keys_table(rows: Iterable[tuple[str, ...]]) -> str:
    return _table(("key", "value", "default", "meaning"), rows)


def _rows(section: dict[str, Any], schema: dict[str, Any], path: str) -> Iterator[tuple[str, ...]]:
    for key, field in section.get("properties", {}).items():
        name, inner = f"{path}.{key}", _object(field, schema)
        entries = _entries(field, schema)
        if inner is not None:
            yield from _rows(inner, schema, name)
        elif entries is not None:
            yield from _rows(entries[1], schema, f"{name}{entries[0]}")
        else:
            yield _key_row(name, field, schema, key in section.get("required", ()))


def _resolve(field: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    """The field without references, and the one alternative of an optional section."""
    for _ in range(10):
        choices = [one for one in field.get("anyOf", ()) if one.get("type") != "null"]
        if "$ref" in field:
            field = schema["$defs"][field["$ref"].rpartition("/")[2]]
        elif len(field.get("allOf", ())) == 1:
            field = field["allOf"][0]
        elif len(choices) == 1 and "$ref" in choices[0]:
            field = choices[0]
        else:
            break
    return field


def _object(field: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any] | None:
    """A section with keys of its own; None if the field is none."""
    found = _resolve(field, schema)
    return found if "properties" in found else None


def _entries(field: dict[str, Any], schema: dict[str, Any]) -> tuple[str, dict[str, Any]] | None:
    """What stands for an entry, and the section that each is, of a mapping or list of sections."""
    found = _resolve(field, schema)
    mappings = [found.get("additionalProperties"), *found.get("patternProperties", {}).values()]
    for sign, entry in (*((".NAME", one) for one in mappings), ("[]", found.get("items"))):
        section = _object(entry, schema) if isinstance(entry, dict) else None
        if section is not None:
            return sign, section
    return None


def _key_row(
    name: str, field: dict[str, Any], schema: dict[str, Any], required: bool
) -> tuple[str, ...]:
    resolved = _resolve(field, schema)
    default = "" if required or "default" not in field else f"`{_literal(field['default'])}`"
    text = field.get("description") or resolved.get("description", "")
    return f"`{name}`", _kind(resolved, schema), default, _escape_text(text)


def _literal(value: Any) -> str:
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, list):
        return f"[{', '.join(map(_literal, value))}]"
    return str(value) if not isinstance(value, str) or value else '""'


def _kind(field: dict[str, Any], schema: dict[str, Any]) -> str:
    """Type and limits of a field, in words."""
    field = _resolve(field, schema)
    if "enum" in field or "const" in field:
        return ", ".join(f"`{_literal(one)}`" for one in field.get("enum", [field.get("const")]))
    for key in ("anyOf", "oneOf"):
        if key in field:
            return " or ".join(dict.fromkeys(_kind(one, schema) for one in field[key]))
    kind = field.get("type", "anything")
    if kind == "array":
        if "prefixItems" in field:
            return f"list of {len(field['prefixItems'])}"
        return f"list of {_kind(field.get('items', {}), schema)}"
    if kind == "object":
        extra = field.get("additionalProperties")
        return f"mapping to {_kind(extra, schema)}" if isinstance(extra, dict) else "mapping"
    signs = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
    limits = [f"{sign} {_limit(field[key])}" for key, sign in signs.items() if key in field]
    return ", ".join([{"string": "text", "null": "null"}.get(kind, kind), *limits])


def _limit(number: float) -> str:
    """A limit; large powers of two are written as such."""
    power = int(number).bit_length() - 1
    return f"2^{power}" if power > 30 and number == 2**power else f"{number:,}"


# ---- tables and figures -----------------------------------------------------------------------


def table_pages(config: Config) -> dict[str, str]:
    """A page for each study: its tables with their columns, and its figures."""
    tables = declarations(Table, optional=True)
    drawn: dict[str, Product] = {
        **declarations(Figure, optional=True), **declarations(Animation, optional=True)
    }  # fmt: skip
    pages = {}
    for study in STUDIES:
        own = [one for one in tables.values() if _study(one) == study]
        pictures = [one for one in drawn.values() if _study(one) == study]
        title = f"Tables: {study.replace('_', ' ')}"
        lines = [
            f"# {title}",
            f"Tables and figures of the study `{study}`, as declared in the code.",
        ]
        for table in own:
            lines += _table_section(table, config)
        if pictures:
            lines += ["## Figures", _table(
                ("figure", "shows", "drawn from"),
                [(f"`{one.name}`", _escape_text(one.title), _inputs(one, config))
                 for one in pictures],
            )]  # fmt: skip
        pages[f"reference/tables/{study.replace('_', '-')}.md"] = "\n\n".join(lines) + "\n"
    return pages


def _study(product: Product) -> str:
    """Name of the folder of the study that declares a product."""
    return product.compute.__module__.split(".studies.")[1].partition(".")[0]


def _table_section(table: Table, config: Config) -> list[str]:
    names = {"string": "text", "int64": "integer", "double": "number", "bool": "true or false"}
    columns = [
        (
            f"`{column.name}`" + (" (key)" if column.key else ""),
            names.get(str(column.type), str(column.type)),
            "" if column.unit in ("", "1") else _escape_text(column.unit),
            _escape_text(column.description) + (" (may be missing)" if column.nullable else ""),
        )
        for column in table.columns
    ]
    inputs = _inputs(table, config)
    lines = [f"## {table.name}", f"{_escape_text(table.title)}."]
    lines.append(f"File: `{table.file()}`." + (f" Computed from {inputs}." if inputs else ""))
    if table.shards_only:
        lines[-1] = f"Kept in shards: `{table.folder}/{table.name}/`."
    lines.append(_table(("column", "type", "unit", "meaning"), columns))
    return lines


def _inputs(product: Product, config: Config) -> str:
    """Names of the inputs with the default configuration; of the first run, if there are runs."""
    run = None
    section = getattr(config, _study(product), config)
    if section is None:  # a study that this configuration leaves out
        return "" if callable(product.inputs) else _names(product.inputs)
    if product.shards is not None:
        run = next(iter(product.shards.runs(config)), None)
    return _names(product.input_names(config, run))


def _names(inputs: Iterable[str]) -> str:
    names = dict.fromkeys(name.partition("/")[0] for name in inputs)
    return ", ".join(f"`{name}`" for name in names)


# ---- Markdown ---------------------------------------------------------------------------------


def _escape_text(text: str) -> str:
    """Text that Markdown shows as it is, apart from code in backticks."""
    text = " ".join(text.replace("``", "`").split())
    text = re.sub(r"<(?=(?:[^`]*`[^`]*`)*[^`]*$)", "&lt;", text)
    return re.sub(r"([*_\[\]])(?=(?:[^`]*`[^`]*`)*[^`]*$)", r"\\\1", text)


def _table(header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A Markdown table; empty if there is no row."""
    lines = [" | ".join(_cell(cell) for cell in row) for row in rows]
    if not lines:
        return ""
    head = [" | ".join(header), " | ".join("---" for _ in header)]
    return "\n".join(f"| {line} |" for line in [*head, *lines])


def _cell(text: str) -> str:
    """A cell of a table; a bar in code is not escaped, since it would show the backslash."""
    parts = text.replace("\n", " ").split("`")
    return "`".join(part if i % 2 else part.replace("|", r"\|") for i, part in enumerate(parts))
