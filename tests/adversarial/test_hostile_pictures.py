"""Pictures that execute code, take all memory, or never end are refused in one line, at once."""

from __future__ import annotations

import io
import os
import struct
import subprocess
import sys
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.origin import read_origin
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage import pictures
from sensory_commutativity.storage.pictures import read_photo

POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 64 64\n(written) (w) file closefile\n"
SECONDS = 2.0


def png(width: int, height: int, rows: bytes = b"") -> bytes:
    """A PNG file of these sides that holds `rows`, however many these are."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def in_format(name: str) -> bytes:
    """A picture of 64 x 64 pixels in one of Pillow's formats."""
    buffer = io.BytesIO()
    Image.new("RGB", (64, 64)).save(buffer, name)
    return buffer.getvalue()


def hostile_pictures() -> Iterator[tuple[str, bytes]]:
    """What each picture is, and its content."""
    yield "postscript", POSTSCRIPT
    yield (
        "postscript with a preview",
        b"\xc5\xd0\xd3\xc6" + struct.pack("<7I", 32, 99, 0, 0, 0, 0, 0),
    )
    for name in ("BMP", "TIFF", "PPM", "EPS", "PDF", "TGA", "ICO", "GIF", "WEBP", "JPEG2000"):
        if Image.registered_extensions() and name in Image.SAVE:
            yield name, in_format(name)
    yield "900 million pixels", png(30_000, 30_000, b"\0" * 100)
    yield "too long", png(64, 20_000, b"\0" * 9 * 20_000)
    yield "too long, and rows are missing", png(64, 20_000)
    yield "no pixels", png(0, 0)
    yield "negative sides", png(2**32 - 1, 2**32 - 1)
    yield "cut", png(64, 64, b"\0" * 9 * 64)[:45]
    yield "rows are missing", png(256, 256)
    yield "text", b"not a picture"
    yield "nothing", b""


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_pictures_of_people_are_png_or_jpeg_and_of_a_bounded_size(tmp_path, monkeypatch, suffix):
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    path = tmp_path / f"a{suffix}"
    for what, content in hostile_pictures():
        path.write_bytes(content)
        start = time.monotonic()
        with pytest.raises(UserError) as caught:
            pytest.fail(f"{what}: {read_photo(path).shape}")
        message = str(caught.value)
        assert message.startswith(f"{path}: ") and message.isprintable(), what
        assert time.monotonic() - start < SECONDS, what
    assert not list((tmp_path / "empty").iterdir())
    path.write_bytes(in_format("PNG"))
    assert read_photo(path).shape == (64, 64, 3)


def test_pictures_among_figures_are_what_their_names_say(tmp_path, monkeypatch):
    run = tmp_path / "run"
    (run / "figures").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    for suffix in (".png", ".gif", ".pdf"):
        path = run / "figures" / f"a{suffix}"
        for what, content in hostile_pictures():
            if suffix == ".gif" and what == "GIF":
                continue
            if suffix == ".png" and what == "too long":  # of a bounded size, so it may be a figure
                continue
            if suffix == ".pdf" and what == "PDF":
                continue
            path.write_bytes(content)
            (bad,) = verify_run(run).bad
            assert bad.status == "damaged", (suffix, what)
            with pytest.raises(UserError):
                read_origin(path)
        path.unlink()
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_an_animation_of_very_many_pixels_is_not_read_to_its_end(tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "MAX_FRAME_PIXELS", 100_000)
    frames = [Image.new("L", (100, 100), i) for i in range(8)]
    path = tmp_path / "run" / "figures" / "a.gif"
    path.parent.mkdir(parents=True)
    frames[0].save(path, save_all=True, append_images=frames[1:] * 20)
    (bad,) = verify_run(tmp_path / "run").bad
    assert "frames have more than" in bad.reason


def test_files_that_are_no_regular_files_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "zero.png").symlink_to("/dev/zero")
    for name in ("pipe", "folder", "zero"):
        with pytest.raises(UserError, match="not a regular file"):
            read_photo(tmp_path / f"{name}.png")
        with pytest.raises(UserError, match="not a regular file"):
            read_origin(tmp_path / f"{name}.png")


def test_hostile_pictures_are_refused_before_anything_slow_is_imported(tmp_path):
    """The command reads both pictures before it imports torch."""
    path = tmp_path / "a.png"
    path.write_bytes(POSTSCRIPT)
    code = (
        "import re, sys; from sensory_commutativity.cli import entry_point\n"
        f"sys.argv[1:] = ['predict', {str(path)!r}, {str(path)!r}]\n"
        "try: entry_point()\n"
        # Not ru_maxrss, which a child inherits from its parent.
        "except SystemExit as end: print(end.code, 'torch' in sys.modules,\n"
        "    int(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1]) // 1024)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    code, torch, megabytes = run.stdout.split()
    assert (code, torch) == ("2", "False") and int(megabytes) < 1000
    assert len(run.stderr.splitlines()) == 1


def test_the_largest_picture_that_is_taken_fits_into_memory(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.zeros((4000, 8000, 3), np.uint8)).save(path)
    assert read_photo(path).nbytes < 100_000_000
    assert isinstance(path, Path)
