"""RAFT with a head for two masks: its building blocks, other glue (Teed and Deng 2020; paper, section IV-A).

Flow has two channels, and so have two masks. The state that is refined is therefore the two masks' logits at an eighth of the resolution, from 0.
What differs from flow: masks live each in its own picture's frame, so correlations are looked up at the pixel itself, which does not move, once.
The second mask depends on the second picture as the first does on the first, so correlations and context are of both, and of how they differ. And
masks have sharp edges, flow mostly not: after the last refinement one more, at a quarter and then at half of the resolution, looks at both pictures,
their features there and how much they differ. One encoder serves for features and context; as in the small RAFT, refinements are brought to full
size bilinearly.
"""

from __future__ import annotations

from functools import partial

import torch
from torch import Tensor, nn
from torch.nn import functional
from torchvision.models.optical_flow.raft import (
    CorrBlock,
    FeatureEncoder,
    FlowHead,
    MotionEncoder,
    RecurrentBlock,
    ResidualBlock,
    UpdateBlock,
)

STRIDE = 8
DIFFERENCES = 2
"""Channels of :func:`least_differences`."""


class MaskRaft(nn.Module):
    """Two pictures to the logits of two masks, refined several times.

    Parameters
    ----------
    widths : tuple of int
        Channels of the encoder's five stages: at half, a quarter, and three times an eighth of the resolution; the third and fourth are equal.
    hidden, context : int
        Channels of the recurrent state and of the context.
    levels, radius : int
        Of the correlation pyramid.
    updates : int
        Refinements at an eighth of the resolution.
    fine, sharp : int
        Channels of the last one, at a quarter and at half of it.
    """

    def __init__(
        self,
        widths=(32, 32, 80, 80, 96),
        hidden: int = 64,
        context: int = 64,
        levels: int = 3,
        radius: int = 3,
        updates: int = 3,
        fine: int = 48,
        sharp: int = 24,
    ):
        super().__init__()
        self.architecture = dict(
            widths=list(widths),
            hidden=hidden,
            context=context,
            levels=levels,
            radius=radius,
            updates=updates,
            fine=fine,
            sharp=sharp,
        )
        self.hidden, self.updates = hidden, updates
        affine = partial(nn.InstanceNorm2d, affine=True)
        self.encoder = FeatureEncoder(
            block=ResidualBlock, layers=tuple(widths), strides=(2, 2, 2, 1), norm_layer=affine
        )
        self.fusion = nn.Conv2d(3 * widths[4], hidden + context, 3, 1, 1)
        self.global_context = nn.Conv2d(context, context, 1)
        self.correlation = CorrBlock(num_levels=levels, radius=radius)
        motion = MotionEncoder(
            in_channels_corr=2 * self.correlation.out_channels,
            corr_layers=(64,),
            flow_layers=(32, 16),
            out_channels=48,
        )
        recurrent = RecurrentBlock(
            input_size=motion.out_channels + context,
            hidden_size=hidden,
            kernel_size=(3,),
            padding=(1,),
        )
        self.update = UpdateBlock(
            motion_encoder=motion,
            recurrent_block=recurrent,
            flow_head=FlowHead(in_channels=hidden, hidden_size=64),
        )
        seen = (
            3 * widths[1] + 2 * 16 + 2 * DIFFERENCES + 32
        )  # features, logits, differences, what the state knows
        self.state_projection = nn.Conv2d(hidden, 32, 1)
        self.refine_quarter = nn.Sequential(
            _mixing(seen, fine), _convolution(fine), _convolution(fine), _convolution(fine)
        )
        seen = (
            3 * widths[0] + 3 * 12 + 2 * 4 + DIFFERENCES + 16
        )  # features, pictures, logits, differences, what the quarter knows
        self.quarter_projection = nn.Conv2d(fine, 16, 1)
        self.refine_half = nn.Sequential(
            _mixing(seen, sharp), _convolution(sharp), nn.Conv2d(sharp, 8, 3, 1, 1)
        )

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Pictures float (n, 3, h, w) in [-1, 1], sides divisible by 8 and at least 64: logits after each refinement, float (n, 2, h, w)."""
        n = len(first)
        shallow = self.encoder.convnormrelu(torch.cat([first, second]))
        middle = self.encoder.layer1(shallow)
        deep = self.encoder.conv(self.encoder.layer3(self.encoder.layer2(middle)))
        correlations = self._correlations(*deep.float().chunk(2))
        state, context = self._initial(deep)
        logits = torch.zeros(n, 2, *deep.shape[2:], device=first.device)
        found = []
        for _ in range(self.updates):
            logits = logits.detach()
            state, change = self.update(
                state, context, correlations.to(state.dtype), logits.to(state.dtype)
            )
            logits = logits + change.float()
            found.append(
                functional.interpolate(
                    logits, scale_factor=STRIDE, mode="bilinear", align_corners=False
                )
            )
        return [
            *found,
            found[-1] + self._refined(first, second, shallow, middle, state, found[-1].detach()),
        ]

    def _initial(self, deep: Tensor) -> tuple[Tensor, Tensor]:
        """The first state and the context."""
        both = self.fusion(torch.cat(_compared(deep), 1))
        context = functional.relu(both[:, self.hidden :])
        context = context + self.global_context(
            context.mean((2, 3), keepdim=True)
        )  # another view is another view at every pixel
        return torch.tanh(both[:, : self.hidden]), context

    def _correlations(self, one: Tensor, other: Tensor) -> Tensor:
        """Of every pixel's features with those around it in the other picture, both ways, in full precision: float (n, c, h, w)."""
        with torch.autocast(one.device.type, enabled=False):
            n, _, height, width = one.shape
            rows, columns = torch.meshgrid(
                torch.arange(height, device=one.device),
                torch.arange(width, device=one.device),
                indexing="ij",
            )
            here = torch.stack([columns, rows]).float()[None].expand(n, -1, -1, -1)
            found = []
            for a, b in ((one, other), (other, one)):
                self.correlation.build_pyramid(a, b)
                found.append(self.correlation.index_pyramid(here))
        return torch.cat(found, 1)

    def _refined(
        self,
        first: Tensor,
        second: Tensor,
        shallow: Tensor,
        middle: Tensor,
        state: Tensor,
        logits: Tensor,
    ) -> Tensor:
        """What the last refinement adds to the logits: float (n, 2, h, w)."""
        kind = state.dtype
        differences = least_differences(first, second).to(kind)
        coarser = [functional.max_pool2d(differences, 2), functional.avg_pool2d(differences, 2)]
        known = _doubled(self.state_projection(state))
        quarter = self.refine_quarter(
            torch.cat(
                [
                    *_compared(middle),
                    functional.pixel_unshuffle(logits, 4).to(kind),
                    *coarser,
                    known,
                ],
                1,
            )
        )
        pictures = functional.pixel_unshuffle(torch.cat([first, second]), 2).to(kind)
        known = _doubled(self.quarter_projection(quarter))
        seen = [
            *_compared(shallow),
            *_compared(pictures),
            functional.pixel_unshuffle(logits, 2).to(kind),
            differences,
            known,
        ]
        return functional.pixel_shuffle(self.refine_half(torch.cat(seen, 1)).float(), 2)


def least_differences(first: Tensor, second: Tensor) -> Tensor:
    """How much each pixel of either picture, at half the resolution, differs from whatever is most alike within a pixel of it in the other.

    Pictures float (n, 3, h, w): float (n, 2, h / 2, w / 2). What a camera's jitter displaces differs little, what moved differs.
    """
    one, other = functional.avg_pool2d(first, 2), functional.avg_pool2d(second, 2)
    height, width = one.shape[2:]
    found = []
    for a, b in ((one, other), (other, one)):
        padded = functional.pad(b, (1, 1, 1, 1), mode="replicate")
        around = [padded[:, :, y : y + height, x : x + width] for y in range(3) for x in range(3)]
        found.append(torch.stack([(a - shifted).abs().sum(1) for shifted in around]).amin(0))
    return torch.stack(found, 1)


def _compared(both: Tensor) -> list[Tensor]:
    """What is stacked for both pictures, float (2 n, c, h, w), side by side with how it differs: three of float (n, c, h, w)."""
    one, other = both.chunk(2)
    return [one, other, (one - other).abs()]


def _doubled(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)


def _mixing(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(inputs, outputs, 1), nn.ReLU())


def _convolution(channels: int) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(channels, channels, 3, 1, 1), nn.ReLU())
