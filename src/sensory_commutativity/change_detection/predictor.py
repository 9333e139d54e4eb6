"""Mask predictors: a model, its view classifier and its decision thresholds, in one file.

A pair is predicted in up to three passes: the model alone; test-time augmentation (:mod:`.tta`)
of the pairs that need it; and for those the view classifier, which settles in which of the two
views a changed region shows something that moved (:mod:`.models.view_classifier`).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from ..errors import UserError
from ..storage.checkpoints import load_state, save_state
from ..storage.files import printable
from .decision import (
    MASK_THRESHOLD,
    DecisionThresholds,
    classify_outcomes,
    remove_small_components,
)
from .models.flownet import MaskFlowNet
from .models.image_difference import image_difference
from .models.raft import MaskRaft
from .models.view_classifier import ViewClassifier, refine_masks
from .outcome import MIN_VISIBLE_PIXELS, OUTCOMES, Outcome
from .tta import MIN_SIDE, SIDE_MULTIPLE, half_resolution, predict_half_resolution, predict_tta
from .untrusted import build_network, read_thresholds

MODELS: dict[str, Callable[..., nn.Module]] = {"raft": MaskRaft, "flownet": MaskFlowNet}
"""Models that are trained, by name."""
UNTRAINED = "difference"
"""Name of the baseline without weights, :mod:`.models.image_difference`."""
PREDICTORS = (*MODELS, UNTRAINED)
CONFIDENT_DIFFERENT = 0.95
"""Mean probability above which "different" needs no second prediction; chosen on development
tuples, where 96 % of the different pairs lie above it."""
FORMAT = 5
"""Version of the predictor files that are written; version 4 can still be read."""
_REMEDY = "train it: run the workflow"


class PredictorError(UserError):
    """A file holds no mask predictor, or a predictor cannot take the pictures."""


class Prediction(NamedTuple):
    """The outcome of one pair, and its change probabilities, float32 (2, h, w)."""

    outcome: Outcome
    probabilities: np.ndarray


class MaskPredictor:
    """Predicts change probabilities and outcomes of pairs of pictures.

    Parameters
    ----------
    name : str
        One of PREDICTORS.
    model : torch.nn.Module, optional
        Maps two batches of pictures to a list of logits, the last of which counts. None for the
        image difference.
    thresholds : DecisionThresholds, optional
    device : str
        ``cpu`` or ``cuda``.
    view_classifier : ViewClassifier, optional
        Without one, masks are left as the model predicts them.
    """

    def __init__(
        self,
        name: str,
        model: nn.Module | None,
        thresholds: DecisionThresholds | None = None,
        device: str = "cpu",
        view_classifier: nn.Module | None = None,
    ):
        self.name = name
        self.model = model.to(device).eval() if model is not None else None
        self.thresholds = thresholds or DecisionThresholds()
        self.device = device
        self.view_classifier = (
            view_classifier.to(device).eval() if view_classifier is not None else None
        )

    def predict(self, first: np.ndarray, second: np.ndarray) -> Prediction:
        """Predict one pair of pictures, RGB, uint8 (h, w, 3). Raises PredictorError."""
        check_same_size(first, second)
        probabilities = self.predict_proba(np.stack([first, second])[None])
        outcome = OUTCOMES[int(classify_outcomes(probabilities, self.thresholds)[0])]
        return Prediction(outcome, probabilities[0])

    def predict_proba(
        self, pictures: np.ndarray, batch_size: int = 16, tta: bool = True
    ) -> np.ndarray:
        """Predict the probability that a pixel shows something that moved.

        Components too small for a visible object are set to 0.

        Parameters
        ----------
        pictures : uint8 (n, 2, h, w, 3)
            RGB; height and width are multiples of SIDE_MULTIPLE, at least MIN_SIDE.
        batch_size : int
        tta : bool
            Whether to refine doubtful pairs by test-time augmentation and the view classifier.

        Returns
        -------
        float32 (n, 2, h, w)

        Raises
        ------
        PredictorError
            If `pictures` has another shape or dtype, or if the model gives no numbers.
        """
        pictures = check_pictures(pictures)
        if self.model is None:
            return remove_small_components(image_difference(pictures))
        probabilities = np.empty(pictures.shape[:4], np.float32)
        with torch.inference_mode():
            for start in range(0, len(pictures), batch_size):
                batch = slice(start, start + batch_size)
                x = to_tensor(pictures[batch], self.device)
                probabilities[batch] = remove_small_components(_sigmoid(self._logits(x)))
                if tta:
                    self._refine(pictures[batch], x, probabilities[batch])
        if not np.isfinite(probabilities).all():
            raise PredictorError(
                "the predictor gives no numbers for these pictures, so its weights are damaged; "
                f"{_REMEDY}"
            )
        return probabilities

    def _refine(self, pictures: np.ndarray, x: Tensor, probabilities: np.ndarray) -> None:
        """Predict doubtful pairs again, and change `probabilities`, float (n, 2, h, w), in place.

        `x` is `pictures` as a tensor.
        """
        changed = probabilities > MASK_THRESHOLD
        mean = probabilities.mean((1, 2, 3))
        moved = np.nonzero(changed.any((1, 2, 3)) & (mean <= MASK_THRESHOLD))[0]
        if len(moved):
            logits = predict_tta(self._logits, x[moved], np.any(changed[moved], axis=1))
            # that something moved is already known, so half the area is enough in the other view
            probabilities[moved] = remove_small_components(_sigmoid(logits), MIN_VISIBLE_PIXELS / 2)
        unsure = np.nonzero((mean > MASK_THRESHOLD) & (mean <= CONFIDENT_DIFFERENT))[0]
        if len(unsure) and half_resolution(x.shape[-2:]):
            logits = predict_half_resolution(self._logits, x[unsure])
            probabilities[unsure] = remove_small_components(_sigmoid(logits))
        if self.view_classifier is not None:
            doubtful = np.union1d(moved, unsure)
            probabilities[doubtful] = refine_masks(
                self.view_classifier, probabilities[doubtful], pictures[doubtful]
            )

    def _logits(self, x: Tensor) -> Tensor:
        """Logits, float (n, 2, h, w), of pictures, float (n, 2, 3, h, w)."""
        assert self.model is not None  # the image difference has no logits
        return self.model(x[:, 0], x[:, 1])[-1].float()

    def save(self, path: Path, provenance: dict[str, str]) -> None:
        """Write the predictor, with weights in half precision, and its provenance."""
        networks = {"model": self.model, "view_classifier": self.view_classifier}
        state = dict(
            format=FORMAT,
            name=self.name,
            thresholds=list(self.thresholds),
            about=dict(provenance),
            **{key: _pack(network) for key, network in networks.items() if network is not None},
        )
        save_state(path, state)


def load_predictor(path: Path, expected: str | None = None, device: str = "cpu") -> MaskPredictor:
    """Read a file of :meth:`MaskPredictor.save`.

    Parameters
    ----------
    path : Path
    expected : str, optional
        The name that the predictor must have.
    device : str

    Raises
    ------
    CheckpointError
        If the file is missing or damaged.
    PredictorError
        If it holds something else, another model than expected, or weights that do not fit.
    """
    state: dict[str, Any] = load_state(path, _REMEDY)
    version, name = state.get("format"), state.get("name")
    known = version in (4, FORMAT) if type(version) is int else False
    if not known or not isinstance(name, str) or name not in PREDICTORS:
        raise PredictorError(f"{path}: no mask predictor, or one of another version; {_REMEDY}")
    if expected is not None and name != expected:
        raise PredictorError(
            f"{path}: holds the model {name!r}, not {expected!r}; give the file of that model"
        )
    try:
        if version == 4:
            state = _upgrade_format_4(state)
        thresholds = read_thresholds(state["thresholds"])
        model = build_network(MODELS[name], state["model"]) if name != UNTRAINED else None
        view_classifier = (
            build_network(ViewClassifier, state["view_classifier"])
            if "view_classifier" in state
            else None
        )
    except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
        reason = printable((str(error).splitlines() or ["?"])[0])[:100]
        raise PredictorError(
            f"{path}: its content does not fit this version's {name!r} ({reason}); {_REMEDY}"
        ) from None
    return MaskPredictor(name, model, thresholds, device, view_classifier)


def check_same_size(first: np.ndarray, second: np.ndarray) -> None:
    """Raise PredictorError if two pictures, (h, w, 3), differ in size."""
    if first.shape != second.shape:
        sizes = [" x ".join(map(str, picture.shape[:2])) for picture in (first, second)]
        raise PredictorError(
            f"the pictures have different sizes, {sizes[0]} and {sizes[1]}; "
            "give two pictures of the same camera"
        )


def check_pictures(pictures: np.ndarray) -> np.ndarray:
    """Return `pictures` as an array, or raise PredictorError if a predictor cannot take them."""
    pictures = np.asarray(pictures)
    shape = pictures.shape
    if pictures.dtype != np.uint8 or len(shape) != 5 or shape[1] != 2 or shape[4] != 3:
        raise PredictorError(
            "pairs of pictures must be uint8 of the shape (n, 2, height, width, 3); "
            f"got {pictures.dtype} {shape}"
        )
    height, width = shape[2:4]
    if min(height, width) < MIN_SIDE or height % SIDE_MULTIPLE or width % SIDE_MULTIPLE:
        raise PredictorError(
            f"the pictures have {height} x {width} pixels; sides must be multiples of "
            f"{SIDE_MULTIPLE} and at least {MIN_SIDE}: scale or crop them, best to the 128 x 128 "
            "of the training pictures"
        )
    return pictures


def to_tensor(pictures: np.ndarray, device: str) -> Tensor:
    """Convert pairs uint8 (n, 2, h, w, 3) to model input: float32 (n, 2, 3, h, w) in [-1, 1]."""
    x = torch.from_numpy(np.ascontiguousarray(pictures)).to(device)
    return x.permute(0, 1, 4, 2, 3).float() / 127.5 - 1


def best_device() -> str:
    """Return ``cuda`` if there is a GPU, otherwise ``cpu``."""
    return "cuda" if torch.cuda.is_available() else "cpu"


def _sigmoid(logits: Tensor) -> np.ndarray:
    return torch.sigmoid(logits).cpu().numpy()


def _pack(network: nn.Module) -> dict[str, Any]:
    """Architecture and weights of a network, the latter in half precision."""
    weights = {
        key: value.half() if value.is_floating_point() else value
        for key, value in network.state_dict().items()
    }
    return dict(architecture=network.architecture, weights=weights)


def _upgrade_format_4(state: dict[str, Any]) -> dict[str, Any]:
    """Translate the names of format 4 to those of FORMAT; their values are the same."""
    keys = {"rule": "thresholds", "judge": "view_classifier"}
    arguments = {"fine": "quarter_channels", "sharp": "half_channels"}  # of MaskRaft
    modules = {
        "rise": "upsample_logits",  # of MaskFlowNet
        "view": "encoder",  # of ViewClassifier
        "verdict": "classifier",
    }

    def rename_weight(key: str) -> str:
        module, _, rest = key.partition(".")
        return f"{modules.get(module, module)}.{rest}"

    state = {keys.get(key, key): value for key, value in state.items()}
    for key in {"model", "view_classifier"} & state.keys():
        packed = state[key]
        state[key] = dict(
            architecture={arguments.get(k, k): v for k, v in packed["architecture"].items()},
            weights={rename_weight(k): v for k, v in packed["weights"].items()},
        )
    return state
