"""Mask predictors: a model, trained or not, with the rule that makes outcomes of its probabilities, and the file that holds both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from ..checkpoints import load_state, save_state
from ..errors import UserError
from .decision import MASK, Rule, cleaned, outcomes, settled
from .difference import difference
from .flownet import MaskFlowNet
from .outcome import OUTCOMES, Outcome
from .raft import MaskRaft

MODELS: dict[str, Callable[..., nn.Module]] = {"raft": MaskRaft, "flownet": MaskFlowNet}
UNTRAINED = "difference"
PREDICTORS = (*MODELS, UNTRAINED)
"""Everything that two pictures can be given to."""
SIDE_STEP, LEAST_SIDE = 32, 64
"""Pixels: sides of pictures are multiples of the first and no less than the second."""
_WAYS = ((), (-1,), (1,), (1, -1))
"""Axes of pairs and of their masks, (n, 2, ..., w), that are turned round: none, as in a mirror, exchanged, both."""
_FORMAT = 3


class PredictorError(UserError):
    """A file holds no mask predictor, or pictures cannot be given to it."""


class Prediction(NamedTuple):
    """What a predictor makes of a pair of pictures: the outcome, and the probabilities of change, float32 (2, h, w)."""

    outcome: Outcome
    probabilities: np.ndarray


class MaskPredictor:
    """A model and its rule.

    Parameters
    ----------
    name : str
        One of PREDICTORS.
    model : torch.nn.Module, optional
        None for the image difference.
    rule : Rule
    device : str
        ``cpu`` or ``cuda``.
    """

    def __init__(self, name: str, model: nn.Module | None, rule: Rule | None = None, device: str = "cpu"):
        self.name, self.rule, self.device = name, rule or Rule(), device
        self.model = model.to(device).eval() if model is not None else None

    def probabilities(self, pictures: np.ndarray, batch_size: int = 16) -> np.ndarray:
        """Probability of change at every pixel: float32 (n, 2, h, w), of pictures uint8 (n, 2, h, w, 3). Raises PredictorError for other arrays.

        Specks too small for anything that counts as in sight are taken away. Pairs in which something seems to have moved are looked at in four ways,
        as they are, mirrored, exchanged and both, whose logits are averaged, and :func:`.decision.settled`.
        """
        pictures = checked(pictures)
        if self.model is None:
            return cleaned(difference(pictures))
        found = cleaned(_sigmoid(self._logits(pictures, batch_size)))
        again = (found > MASK).any((1, 2, 3)) & (found.mean((1, 2, 3)) <= MASK)
        if again.any():
            found[again] = settled(cleaned(_sigmoid(self._logits(pictures[again], batch_size, _WAYS))))
        return found

    def _logits(self, pictures: np.ndarray, batch_size: int, ways: Sequence[tuple[int, ...]] = ((),)) -> np.ndarray:
        """Mean logits over several ways of looking at each pair, each the axes that are turned round: float32 (n, 2, h, w)."""
        found = np.empty(pictures.shape[:4], np.float32)
        with torch.inference_mode():
            for start in range(0, len(pictures), batch_size):
                x = as_tensor(pictures[start : start + batch_size], self.device)
                seen = []
                for way in ways:
                    turned = x.flip(way)
                    seen.append(self.model(turned[:, 0], turned[:, 1])[-1].float().flip(way))
                found[start : start + batch_size] = torch.stack(seen).mean(0).cpu().numpy()
        return found

    def predict(self, first: np.ndarray, second: np.ndarray) -> Prediction:
        """What became of one pair of pictures, uint8 (h, w, 3) each, as :meth:`probabilities` sees them. Raises PredictorError for other arrays."""
        if first.shape != second.shape:
            raise PredictorError(f"the pictures have different sizes, {_size(first)} and {_size(second)}; give two pictures of the same camera")
        probabilities = self.probabilities(np.stack([first, second])[None])
        return Prediction(OUTCOMES[int(outcomes(probabilities, self.rule)[0])], probabilities[0])

    def save(self, path: Path, about: dict[str, str]) -> None:
        """Write the predictor, its weights in half precision, and what it comes from."""
        weights = {key: value.half() if value.is_floating_point() else value for key, value in self.model.state_dict().items()} if self.model else {}
        save_state(
            path,
            dict(
                format=_FORMAT,
                name=self.name,
                architecture=getattr(self.model, "architecture", {}),
                rule=list(self.rule),
                about=dict(about),
                weights=weights,
            ),
        )


def load_predictor(path: Path, expected: str | None = None, device: str = "cpu") -> MaskPredictor:
    """Read what :meth:`MaskPredictor.save` wrote; `expected` refuses another model. Raises PredictorError or CheckpointError with the remedy."""
    state: dict[str, Any] = load_state(path, "train it: run the workflow")
    if not isinstance(state, dict) or state.get("format") != _FORMAT or state.get("name") not in PREDICTORS:
        raise PredictorError(f"{path}: no mask predictor, or one of another version; train it: run the workflow")
    if expected is not None and state["name"] != expected:
        raise PredictorError(f"{path}: holds the model {state['name']!r}, not {expected!r}; give the file of that model")
    try:
        rule = Rule(*state["rule"])
        if state["name"] == UNTRAINED:
            return MaskPredictor(UNTRAINED, None, rule)
        model = MODELS[state["name"]](**state["architecture"])
        model.load_state_dict({key: value.float() if value.is_floating_point() else value for key, value in state["weights"].items()})
    except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
        first = (str(error).splitlines() or ["?"])[0][:100]
        raise PredictorError(f"{path}: weights of another architecture than this version's {state['name']!r} ({first}); train it anew") from None
    return MaskPredictor(state["name"], model, rule, device)


def checked(pictures: np.ndarray) -> np.ndarray:
    """The pictures, if a predictor can take them. Raises PredictorError with what is wrong."""
    pictures = np.asarray(pictures)
    if pictures.dtype != np.uint8 or pictures.ndim != 5 or pictures.shape[1] != 2 or pictures.shape[4] != 3:
        raise PredictorError(f"pairs of pictures must be uint8 of the shape (n, 2, height, width, 3); got {pictures.dtype} {pictures.shape}")
    height, width = pictures.shape[2:4]
    if min(height, width) < LEAST_SIDE or height % SIDE_STEP or width % SIDE_STEP:
        raise PredictorError(
            f"the pictures have {height} x {width} pixels; sides must be multiples of {SIDE_STEP} from {LEAST_SIDE} on: scale or crop them, "
            "best to the 128 x 128 that the models were trained with"
        )
    return pictures


def as_tensor(pictures: np.ndarray, device: str) -> Tensor:
    """Pairs uint8 (n, 2, h, w, 3) as models take them: float32 (n, 2, 3, h, w) in [-1, 1]."""
    return torch.from_numpy(np.ascontiguousarray(pictures)).to(device).permute(0, 1, 4, 2, 3).float() / 127.5 - 1


def best_device() -> str:
    """A GPU if there is one."""
    return "cuda" if torch.cuda.is_available() else "cpu"


def _sigmoid(logits: np.ndarray) -> np.ndarray:
    return torch.sigmoid(torch.from_numpy(logits)).numpy()


def _size(picture: np.ndarray) -> str:
    return " x ".join(str(side) for side in picture.shape[:2])
