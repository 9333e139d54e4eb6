"""The command that finds what changed between two pictures."""

from __future__ import annotations

from pathlib import Path

import click

from .options import FILE

SHIPPED = Path(__file__).resolve().parents[3] / "results/paper/models/masks/raft.predictor"
"""The predictor that was trained at the paper's sizes; it is part of the repository."""


@click.command()
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@click.option("--predictor", type=FILE, default=SHIPPED, help="A trained predictor.")
@click.option("--out", type=FILE, help="Picture to write [default: SECOND-moved.png].")
def predict(first: Path, second: Path, predictor: Path, out: Path | None) -> None:
    """Find what changed between two pictures of one camera.

    Prints the outcome, and writes a picture in which the changes are outlined. The outcome is one
    of three: the same view, another view, or the same view in which objects moved. FIRST and SECOND
    are PNG or JPEG files of the same size, at least 64 pixels per side.
    """
    from ..change_detection.predict import predict_files

    out = out or second.with_name(f"{second.stem}-moved.png")
    click.echo(predict_files(first, second, predictor, out))
