"""Commands that describe and check a robot of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..extras import extra_needed

if TYPE_CHECKING:
    from ..worlds.apartment.drafting.probing import DofProbe

FILE: Any = click.Path(dir_okay=False, path_type=Path)


@click.group()
def robot() -> None:
    """Describe and check a robot of your own.

    `sencom robot init my.urdf` writes my.yaml, `sencom robot check my.yaml` tries it, and
    `sencom measure --robot my.yaml --scene rs-stand-in` measures it.
    """


@robot.command()
@click.argument("urdf")
@click.option("--out", type=FILE, help="YAML file to write  [default: URDF.yaml in this folder]")
@click.option("--name", help="Name of the robot  [default: that of the URDF]")
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def init(urdf: str, out: Path | None, name: str | None, force: bool) -> None:
    """Write a first description of the robot in URDF, with comments.

    URDF is a file, of xacro too if the extra xacro is installed, or package://NAME/PATH of an
    installed package. Joints become degrees of freedom with guessed groups and velocities, wheels,
    axle and camera are found, start positions keep away from stops, and pairs of links that touch
    in every pose are listed.
    """
    with extra_needed("apartment"):
        from ..worlds.apartment.drafting.draft import draft_robot
        from ..worlds.apartment.drafting.yaml_text import format_draft
        from ..worlds.apartment.files import FileError, locate
        from ..worlds.apartment.robots.urdf import RobotError

        try:
            path = locate(urdf, Path())
        except FileError as error:
            raise RobotError(f"{urdf}: the file {error}") from None
        out = out or Path(f"{path.stem}.yaml")
        if out.exists() and out.samefile(path):
            raise click.UsageError(f"{out}: is the URDF itself; choose another --out")
        if out.exists() and not force:
            raise click.UsageError(f"{out}: exists; choose another --out, or give --force")
        if not out.parent.is_dir():
            raise click.UsageError(f"--out {out}: there is no folder {out.parent}; create it")
        draft = draft_robot(path, out, name)
        out.write_text(format_draft(draft, f"sencom robot init {path.name}"), encoding="utf-8")
    click.echo(f"{out}: {len(draft.settings['dofs'])} degrees of freedom")
    for note in draft.notes:
        click.echo(f"note: {note}")
    click.echo(f"next: sencom robot check {out} --draw {out.with_suffix('.png').name}")


@robot.command()
@click.argument("description", type=FILE)
@click.option("--draw", type=FILE, help="Picture of the robot to write: PNG, PDF or SVG.")
@click.option(
    "-n",
    "--tries",
    default=3,
    show_default=True,
    help="Experiments of every degree of freedom in free space; 0 for none.",
)
@click.option("--seed", default=0, show_default=True, help="Determines starts and sequences.")
@click.option("--force", is_flag=True, help="Overwrite an existing picture.")
def check(description: Path, draw: Path | None, tries: int, seed: int, force: bool) -> None:
    """Check the robot that DESCRIPTION, a YAML file, describes.

    Reads its URDF and all meshes, and drives every degree of freedom alone in free space: how far
    it moves of what it is told, whether it starts at a stop or touches the robot itself, and
    whether two orders of its actions end equal. The exit code is 1 if one does not do what it is
    told.
    """
    with extra_needed("apartment"):
        from ..worlds.apartment.drafting.portrait import draw_portrait
        from ..worlds.apartment.drafting.probing import probe_robot
        from ..worlds.apartment.robots.checks import check_shapes
        from ..worlds.apartment.robots.loading import load_robot

        if draw is not None:
            _check_picture(draw, force)
        loaded = load_robot(description)
        check_shapes(loaded)
        if draw is not None:
            draw_portrait(loaded, draw)
            click.echo(f"written: {draw}")
        for note in loaded.urdf.notes:
            click.echo(f"note: {note}")
        probes = probe_robot(loaded, tries, seed)
    for line in describe_probes(probes):
        click.echo(line)
    if any(probe.problems for probe in probes):
        raise SystemExit(1)


def describe_probes(probes: list[DofProbe]) -> list[str]:
    """Lines of a table: what each degree of freedom did, and what is wrong with it."""
    width = max(len(probe.name) for probe in probes)
    lines = [f"{'':{width}}  {'asked':>8}  {'moved':>8}  unit  commutes"]
    for probe in probes:
        commuted = f"{probe.commuted:8.0%}" if probe.n else f"{'-':>8}"
        problems = "; ".join(probe.problems)
        lines.append(
            f"{probe.name:{width}}  {probe.asked:8.3f}  {probe.moved:8.3f}  {probe.unit:4}  "
            f"{commuted}  {problems}".rstrip()
        )
    return lines


def warn_about_robot(world: Any) -> None:
    """Say which degrees of freedom of a robot in an apartment do not do what they are told."""
    robot = getattr(world, "robot", None)
    if robot is None or not hasattr(robot, "urdf"):
        return
    from ..worlds.apartment.drafting.probing import probe_robot

    for probe in probe_robot(robot):
        for problem in probe.problems:
            click.echo(f"warning: {probe.name}: {problem}", err=True)


def _check_picture(draw: Path, force: bool) -> None:
    if draw.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise click.UsageError(f"--draw {draw}: expected a name that ends in .png, .pdf or .svg")
    if draw.exists() and not force:
        raise click.UsageError(f"{draw}: exists; choose another --draw, or give --force")
    if not draw.parent.is_dir():
        raise click.UsageError(f"--draw {draw}: there is no folder {draw.parent}; create it")
