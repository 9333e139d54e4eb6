"""Mask predictors: a model, trained or not, its judge of places, the rule that makes outcomes of its probabilities, and the file that holds all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from ..errors import UserError
from ..storage.checkpoints import load_state, save_state
from .decision import MASK, DecisionThresholds, outcomes, remove_small_components
from .models.flownet import MaskFlowNet
from .models.image_difference import difference
from .models.raft import MaskRaft
from .models.view_classifier import ViewClassifier, refine_masks
from .outcome import OUTCOMES, SEEN, Outcome
from .tta import LEAST_SIDE, SIDE_STEP, farther, predict_half_resolution, predict_tta

MODELS: dict[str, Callable[..., nn.Module]] = {"raft": MaskRaft, "flownet": MaskFlowNet}
UNTRAINED = "difference"
PREDICTORS = (*MODELS, UNTRAINED)
"""Everything that two pictures can be given to."""
SURE = 0.95
"""Mean probability up to which pictures that seem different get a second look; chosen on development tuples: 96 % of different ones have more."""
_FORMAT = 4


class PredictorError(UserError):
    """A file holds no mask predictor, or pictures cannot be given to it."""


class Prediction(NamedTuple):
    """What a predictor makes of a pair of pictures: the outcome, and the probabilities of change, float32 (2, h, w)."""

    outcome: Outcome
    probabilities: np.ndarray


class MaskPredictor:
    """A model, its rule and its judge.

    Parameters
    ----------
    name : str
        One of PREDICTORS.
    model : torch.nn.Module, optional
        None for the image difference.
    rule : DecisionThresholds
    device : str
        ``cpu`` or ``cuda``.
    judge : ViewClassifier, optional
        None leaves doubts about which view a thing is in as they are.
    """

    def __init__(
        self,
        name: str,
        model: nn.Module | None,
        rule: DecisionThresholds | None = None,
        device: str = "cpu",
        view_classifier: ViewClassifier | None = None,
    ):
        self.name, self.rule, self.device = name, rule or DecisionThresholds(), device
        self.model = model.to(device).eval() if model is not None else None
        self.view_classifier = judge.to(device).eval() if judge is not None else None

    def probabilities(
        self, pictures: np.ndarray, batch_size: int = 16, again: bool = True
    ) -> np.ndarray:
        """Probability of change at every pixel: float32 (n, 2, h, w), of pictures uint8 (n, 2, h, w, 3). Raises PredictorError for other arrays.

        Specks too small for anything that counts as in sight are taken away. If `again`, pairs in which something seems to have moved, or which only
        just seem different, get a second look (:mod:`.second_look`), and the judge says which view a thing is in (:mod:`.judge`).
        """
        pictures = checked(pictures)
        if self.model is None:
            return remove_small_components(difference(pictures))
        found = np.empty(pictures.shape[:4], np.float32)
        with torch.inference_mode():
            for start in range(0, len(pictures), batch_size):
                part = slice(start, start + batch_size)
                x = as_tensor(pictures[part], self.device)
                found[part] = remove_small_components(_probabilities(self._see(x)))
                if again:
                    self._apply_tta(pictures[part], x, found[part])
        return found

    def _apply_tta(self, pictures: np.ndarray, x: Tensor, found: np.ndarray) -> None:
        """Mend what was found at first sight, float (n, 2, h, w), where it is in doubt. `pictures` and `x` are the same."""
        changed = found > MASK
        mean = found.mean((1, 2, 3))
        moved = np.nonzero(changed.any((1, 2, 3)) & (mean <= MASK))[0]
        if len(moved):
            # that something moved is known by now, so of the other view less needs to be in sight
            found[moved] = remove_small_components(
                _probabilities(predict_tta(self._see, x[moved], changed[moved].any(1))), SEEN / 2
            )
        unsure = np.nonzero((mean > MASK) & (mean <= SURE))[0]
        if len(unsure) and farther(x.shape[-2:]):
            found[unsure] = remove_small_components(
                _probabilities(predict_half_resolution(self._see, x[unsure]))
            )
        if self.view_classifier is not None:
            doubtful = np.union1d(moved, unsure)
            found[doubtful] = refine_masks(self.view_classifier, found[doubtful], pictures[doubtful])

    def _see(self, pictures: Tensor) -> Tensor:
        """Logits, float (n, 2, h, w), of pictures float (n, 2, 3, h, w)."""
        return self.model(pictures[:, 0], pictures[:, 1])[-1].float()

    def predict(self, first: np.ndarray, second: np.ndarray) -> Prediction:
        """What became of one pair of pictures, uint8 (h, w, 3) each, as :meth:`probabilities` sees them. Raises PredictorError for other arrays."""
        of_one_size(first, second)
        probabilities = self.probabilities(np.stack([first, second])[None])
        return Prediction(OUTCOMES[int(outcomes(probabilities, self.rule)[0])], probabilities[0])

    def save(self, path: Path, about: dict[str, str]) -> None:
        """Write the predictor, its weights in half precision, and what it comes from."""
        networks = {
            key: _packed(network)
            for key, network in (("model", self.model), ("judge", self.view_classifier))
            if network is not None
        }
        save_state(
            path,
            dict(
                format=_FORMAT, name=self.name, rule=list(self.rule), about=dict(about), **networks
            ),
        )


def load_predictor(path: Path, expected: str | None = None, device: str = "cpu") -> MaskPredictor:
    """Read what :meth:`MaskPredictor.save` wrote; `expected` refuses another model. Raises PredictorError or CheckpointError with the remedy."""
    state: dict[str, Any] = load_state(path, "train it: run the workflow")
    if (
        not isinstance(state, dict)
        or state.get("format") != _FORMAT
        or state.get("name") not in PREDICTORS
    ):
        raise PredictorError(
            f"{path}: no mask predictor, or one of another version; train it: run the workflow"
        )
    if expected is not None and state["name"] != expected:
        raise PredictorError(
            f"{path}: holds the model {state['name']!r}, not {expected!r}; give the file of that model"
        )
    try:
        rule = DecisionThresholds(*state["rule"])
        if state["name"] == UNTRAINED:
            return MaskPredictor(UNTRAINED, None, rule)
        model = _unpacked(MODELS[state["name"]], state["model"])
        judge = _unpacked(ViewClassifier, state["judge"]) if "judge" in state else None
    except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
        first = (str(error).splitlines() or ["?"])[0][:100]
        raise PredictorError(
            f"{path}: weights of another architecture than this version's {state['name']!r} ({first}); train it anew"
        ) from None
    return MaskPredictor(state["name"], model, rule, device, judge)


def of_one_size(first: np.ndarray, second: np.ndarray) -> None:
    """Raises PredictorError if two pictures, uint8 (h, w, 3), have different sizes."""
    if first.shape != second.shape:
        raise PredictorError(
            f"the pictures have different sizes, {_size(first)} and {_size(second)}; give two pictures of the same camera"
        )


def checked(pictures: np.ndarray) -> np.ndarray:
    """The pictures, if a predictor can take them. Raises PredictorError with what is wrong."""
    pictures = np.asarray(pictures)
    if (
        pictures.dtype != np.uint8
        or pictures.ndim != 5
        or pictures.shape[1] != 2
        or pictures.shape[4] != 3
    ):
        raise PredictorError(
            f"pairs of pictures must be uint8 of the shape (n, 2, height, width, 3); got {pictures.dtype} {pictures.shape}"
        )
    height, width = pictures.shape[2:4]
    if min(height, width) < LEAST_SIDE or height % SIDE_STEP or width % SIDE_STEP:
        raise PredictorError(
            f"the pictures have {height} x {width} pixels; sides must be multiples of {SIDE_STEP} from {LEAST_SIDE} on: scale or crop them, "
            "best to the 128 x 128 that the models were trained with"
        )
    return pictures


def as_tensor(pictures: np.ndarray, device: str) -> Tensor:
    """Pairs uint8 (n, 2, h, w, 3) as models take them: float32 (n, 2, 3, h, w) in [-1, 1]."""
    return (
        torch.from_numpy(np.ascontiguousarray(pictures)).to(device).permute(0, 1, 4, 2, 3).float()
        / 127.5
        - 1
    )


def best_device() -> str:
    """A GPU if there is one."""
    return "cuda" if torch.cuda.is_available() else "cpu"


def _packed(network: nn.Module) -> dict[str, Any]:
    """Its architecture and its weights, those in half precision."""
    weights = {
        key: value.half() if value.is_floating_point() else value
        for key, value in network.state_dict().items()
    }
    return dict(architecture=network.architecture, weights=weights)


def _unpacked(kind: Callable[..., nn.Module], packed: dict[str, Any]) -> nn.Module:
    """The reverse of :func:`_packed`. Raises what torch and Python do for weights of another architecture."""
    network = kind(**packed["architecture"])
    network.load_state_dict(
        {
            key: value.float() if value.is_floating_point() else value
            for key, value in packed["weights"].items()
        }
    )
    return network


def _probabilities(logits: Tensor) -> np.ndarray:
    return torch.sigmoid(logits).cpu().numpy()


def _size(picture: np.ndarray) -> str:
    return " x ".join(str(side) for side in picture.shape[:2])
