"""The pictures in a report of Snakemake: one HTML file with all figures as data URIs."""

from __future__ import annotations

import base64
import binascii
import re
from pathlib import Path

from ..errors import UserError
from ..storage.files import read_bounded

REPORT = "report.html"
MAX_BYTES = 200_000_000
"""Size of a report; chosen: eight times that of the paper's."""
_URI = re.compile(
    rb'"data:image/(?:png|gif)[^",]{0,200}?filename=([\w.-]{1,100});base64,([A-Za-z0-9+/=]*)"'
)


def read_pictures(path: Path) -> dict[str, bytes]:
    """Content of the pictures in a report by file name. Raises UserError."""
    data = read_bounded(path, UserError, "run the workflow again", MAX_BYTES)
    pictures = {}
    for match in _URI.finditer(data):
        try:
            pictures[match[1].decode()] = base64.b64decode(match[2], validate=True)
        except (binascii.Error, ValueError):
            pictures[match[1].decode()] = b""
    return pictures
