"""The command that finds what changed between two pictures."""

from __future__ import annotations

from pathlib import Path

import click

from ..extras import extra_needed
from .options import FILE


@click.command()
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@click.option("--predictor", type=FILE, help="A trained predictor [default: the package's].")
@click.option("--out", type=FILE, help="Picture to write [default: SECOND-moved.png].")
@click.option("--force", is_flag=True, help="Overwrite an existing picture (never an input).")
def predict(
    first: Path, second: Path, predictor: Path | None, out: Path | None, force: bool
) -> None:
    """Find what changed between two pictures of one camera.

    Prints the outcome, and writes a picture in which the changes are outlined. The outcome is one
    of three: the same view, another view, or the same view in which objects moved. FIRST and SECOND
    are PNG or JPEG files of the same size, at least 64 pixels per side.
    """
    with extra_needed("change-detection"):
        from ..change_detection.predict import predict_files

    out = out or second.with_name(f"{second.stem}-moved.png")
    click.echo(predict_files(first, second, predictor, out, force))
