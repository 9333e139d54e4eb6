"""A command that is stopped at any time prints no traceback, and what it left can be continued."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from sensory_commutativity.measurement.measurement import Measurement

SENCOM = Path(sys.executable).parent / "sencom"
MEASURE = ["measure", "corridor", "-n", "400", "--length", "20"]


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [str(SENCOM), *arguments], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def test_a_measurement_that_is_stopped_at_random_times_continues_and_is_the_same(tmp_path):
    rng = np.random.default_rng(0)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
        process = start(tmp_path, *MEASURE, "--out", "m.parquet")
        time.sleep(float(rng.uniform(0.25, 1.5)))
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        # on a busy machine Python itself may still be starting, and print a traceback of its own
        assert "sensory_commutativity" not in errors, errors
        assert process.returncode in (0, 130, -number), errors
        assert not list(tmp_path.glob("*.part*"))
    for out in ("m.parquet", "whole.parquet"):
        assert start(tmp_path, *MEASURE, "--out", out).wait(60) == 0
    continued, whole = (Measurement.load(tmp_path / f"{name}.parquet") for name in ("m", "whole"))
    assert np.array_equal(continued.distances, whole.distances)


@pytest.mark.parametrize("utf8", ["0", "1"])
def test_names_outside_of_ascii_are_read_and_written_in_any_locale(tmp_path, utf8):
    folder = tmp_path / "ünïcödé"
    folder.mkdir()
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": utf8, "PYTHONCOERCECLOCALE": "0"}
    out = folder / "é.parquet"
    command = [str(SENCOM), "measure", "corridor", "-n", "3", "--length", "3", "--out", str(out)]
    result = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert result.returncode == 0 and b"Traceback" not in result.stderr, result.stderr
    assert len(Measurement.load(out)) == 3
