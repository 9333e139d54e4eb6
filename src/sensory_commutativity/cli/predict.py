"""The command that finds what changed between two pictures."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import UserError
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
    are PNG, JPEG or TIFF files of the same size, at least 64 pixels per side.
    """
    check_inputs(first, second, predictor)
    with extra_needed("change-detection"):
        from ..change_detection.predict import predict_files

    out = out or second.with_name(f"{second.stem}-moved.png")
    click.echo(predict_files(first, second, predictor, out, force))


def check_inputs(first: Path, second: Path, predictor: Path | None) -> None:
    """Check the files before torch is imported, which takes seconds. Raises UserError."""
    from importlib.util import find_spec

    from ..storage.files import check_regular_file
    from ..storage.pictures import read_photo

    if find_spec("torch") is None:
        with extra_needed("change-detection"):
            raise ModuleNotFoundError(name="torch")
    if predictor is not None:
        check_regular_file(predictor, UserError, "give a trained predictor")
    for path in (first, second):
        read_photo(path)
