"""RAFT that predicts two masks: its building blocks, connected for masks in place of flow.

Teed and Deng 2020, "RAFT: Recurrent All-Pairs Field Transforms for Optical Flow",
https://arxiv.org/abs/2003.12039; paper, section IV-A. Flow has two channels, and so have the logits
of two masks: they are the state that is refined, from 0, at an eighth of the resolution. The
differences from RAFT:

- Each mask lives in the frame of its own picture. Correlations are therefore looked up around the
  pixel itself, once, and not around a position that moves with the flow.
- The second mask depends on the second picture as the first does on the first. Correlations and
  context are therefore computed from both pictures and their difference.
- Masks have sharp edges, flow mostly has not. A last refinement at a quarter and at half of the
  resolution sees both pictures, their features and their difference.
- One encoder computes both features and context.

As in the small RAFT, logits are upsampled bilinearly.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import torch
import torch.nn.functional as F
from torch import Tensor, nn
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
"""Pixels of the pictures per pixel of the refined logits, as in RAFT."""
DIFFERENCE_CHANNELS = 2
"""Channels of :func:`smallest_differences`."""
STATE_CHANNELS = 32
"""Channels of the recurrent state that the refinement at a quarter sees; chosen."""
QUARTER_STATE_CHANNELS = 16
"""Channels of the quarter's features that the refinement at half sees; chosen."""


class MaskRaft(nn.Module):
    """Predicts the logits of two masks and refines them several times.

    Parameters
    ----------
    widths : sequence of int
        Channels of the encoder's five stages: at half, at a quarter, and three times at an eighth
        of the resolution; the third and fourth are equal.
    hidden, context : int
        Channels of the recurrent state and of the context.
    levels, radius : int
        Levels of the correlation pyramid, and radius of the look-up in each.
    updates : int
        Refinements at an eighth of the resolution.
    quarter_channels, half_channels : int
        Channels of the last refinement at a quarter and at half of the resolution.
    """

    def __init__(
        self,
        widths: Sequence[int] = (32, 32, 80, 80, 96),
        hidden: int = 64,
        context: int = 64,
        levels: int = 3,
        radius: int = 3,
        updates: int = 3,
        quarter_channels: int = 48,
        half_channels: int = 24,
    ):
        super().__init__()
        self.architecture = dict(
            widths=list(widths),
            hidden=hidden,
            context=context,
            levels=levels,
            radius=radius,
            updates=updates,
            quarter_channels=quarter_channels,
            half_channels=half_channels,
        )
        self.hidden = hidden
        self.updates = updates
        self.encoder = FeatureEncoder(
            block=ResidualBlock,
            layers=tuple(widths),
            strides=(2, 2, 2, 1),
            norm_layer=partial(nn.InstanceNorm2d, affine=True),
        )
        self.fusion = nn.Conv2d(3 * widths[4], hidden + context, 3, 1, 1)
        self.global_context = nn.Conv2d(context, context, 1)
        self.correlation = CorrBlock(num_levels=levels, radius=radius)
        self.update = _update_block(2 * self.correlation.out_channels, hidden, context)
        self.state_projection = nn.Conv2d(hidden, STATE_CHANNELS, 1)
        self.refine_quarter = _quarter_refinement(widths[1], quarter_channels)
        self.quarter_projection = nn.Conv2d(quarter_channels, QUARTER_STATE_CHANNELS, 1)
        self.refine_half = _half_refinement(widths[0], half_channels)

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Predict the logits of both masks after each refinement.

        Parameters
        ----------
        first, second : float (n, 3, h, w)
            Pictures in [-1, 1]; height and width are multiples of 8, at least 64.

        Returns
        -------
        list of float32 (n, 2, h, w)
            ``updates + 1`` predictions, the best one last.
        """
        fmap_half = self.encoder.convnormrelu(torch.cat([first, second]))  # (2 n, c, h / 2, w / 2)
        fmap_quarter = self.encoder.layer1(fmap_half)  # (2 n, c, h / 4, w / 4)
        fmap = self.encoder.layer3(self.encoder.layer2(fmap_quarter))
        fmap = self.encoder.conv(fmap)  # (2 n, c, h / 8, w / 8)
        fmap1, fmap2 = fmap.float().chunk(2)
        corr = self._correlate(fmap1, fmap2)
        net, inp = self._initial_state(fmap)
        logits = torch.zeros(len(first), 2, *fmap.shape[2:], device=first.device)
        predictions = []
        for _ in range(self.updates):
            logits = logits.detach()
            net, delta = self.update(net, inp, corr.to(net.dtype), logits.to(net.dtype))
            logits = logits + delta.float()
            predictions.append(
                F.interpolate(logits, scale_factor=STRIDE, mode="bilinear", align_corners=False)
            )
        coarse = predictions[-1]
        delta = self._refine(first, second, fmap_half, fmap_quarter, net, coarse.detach())
        return [*predictions, coarse + delta]

    def _initial_state(self, fmap: Tensor) -> tuple[Tensor, Tensor]:
        """Recurrent state and context, float (n, c, h / 8, w / 8), of both pictures' features."""
        fused = self.fusion(torch.cat(concat_abs_diff(fmap), 1))
        inp = F.relu(fused[:, self.hidden :])
        # whether the views differ altogether is the same for every pixel
        inp = inp + self.global_context(inp.mean((2, 3), keepdim=True))
        return torch.tanh(fused[:, : self.hidden]), inp

    def _correlate(self, fmap1: Tensor, fmap2: Tensor) -> Tensor:
        """Correlate each pixel with those around it in the other picture, in both directions.

        In full precision, as in RAFT: float32 (n, c, h / 8, w / 8).
        """
        with torch.autocast(fmap1.device.type, enabled=False):
            n, _, height, width = fmap1.shape
            y, x = torch.meshgrid(
                torch.arange(height, device=fmap1.device),
                torch.arange(width, device=fmap1.device),
                indexing="ij",
            )
            coords = torch.stack([x, y]).float()[None].expand(n, -1, -1, -1)
            features = []
            for query, target in ((fmap1, fmap2), (fmap2, fmap1)):
                self.correlation.build_pyramid(query, target)
                features.append(self.correlation.index_pyramid(coords))
        return torch.cat(features, 1)

    def _refine(
        self,
        first: Tensor,
        second: Tensor,
        fmap_half: Tensor,
        fmap_quarter: Tensor,
        net: Tensor,
        logits: Tensor,
    ) -> Tensor:
        """What the refinement at a quarter and at half adds to the logits: float32 (n, 2, h, w)."""
        dtype = net.dtype
        differences = smallest_differences(first, second).to(dtype)  # (n, 2, h / 2, w / 2)
        quarter_inputs = [
            *concat_abs_diff(fmap_quarter),
            F.pixel_unshuffle(logits, 4).to(dtype),
            F.max_pool2d(differences, 2),
            F.avg_pool2d(differences, 2),
            upsample2x(self.state_projection(net)),
        ]
        quarter = self.refine_quarter(torch.cat(quarter_inputs, 1))  # (n, c, h / 4, w / 4)
        pictures = F.pixel_unshuffle(torch.cat([first, second]), 2).to(dtype)
        half_inputs = [
            *concat_abs_diff(fmap_half),
            *concat_abs_diff(pictures),
            F.pixel_unshuffle(logits, 2).to(dtype),
            differences,
            upsample2x(self.quarter_projection(quarter)),
        ]
        half = self.refine_half(torch.cat(half_inputs, 1))  # (n, 8, h / 2, w / 2)
        return F.pixel_shuffle(half.float(), 2)


def smallest_differences(first: Tensor, second: Tensor) -> Tensor:
    """Difference of each pixel to the most similar one nearby in the other picture.

    Pictures are halved, and pixels up to one pixel away are compared. Content that the camera's
    jitter displaces differs little, what moved differs much.

    Parameters
    ----------
    first, second : float (n, 3, h, w)

    Returns
    -------
    float (n, 2, h / 2, w / 2)
        Sums of absolute differences over the colour channels, for either picture.
    """
    views = F.avg_pool2d(first, 2), F.avg_pool2d(second, 2)
    height, width = views[0].shape[2:]
    smallest = []
    for view, reference in (views, views[::-1]):
        padded = F.pad(reference, (1, 1, 1, 1), mode="replicate")
        shifts = [padded[:, :, y : y + height, x : x + width] for y in range(3) for x in range(3)]
        distances = torch.stack([(view - shifted).abs().sum(1) for shifted in shifts])
        smallest.append(distances.amin(0))
    return torch.stack(smallest, 1)


def concat_abs_diff(both: Tensor) -> list[Tensor]:
    """Split what is stacked for both pictures, and append the absolute difference.

    (2 n, c, h, w) becomes three tensors of (n, c, h, w), to be concatenated along the channels.
    """
    first, second = both.chunk(2)
    return [first, second, (first - second).abs()]


def upsample2x(x: Tensor) -> Tensor:
    """Double height and width of (n, c, h, w) bilinearly."""
    return F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)


def _update_block(corr_channels: int, hidden: int, context: int) -> UpdateBlock:
    """RAFT's update block in the sizes of this model."""
    motion = MotionEncoder(
        in_channels_corr=corr_channels, corr_layers=(64,), flow_layers=(32, 16), out_channels=48
    )
    recurrent = RecurrentBlock(
        input_size=motion.out_channels + context,
        hidden_size=hidden,
        kernel_size=(3,),
        padding=(1,),
    )
    return UpdateBlock(
        motion_encoder=motion,
        recurrent_block=recurrent,
        flow_head=FlowHead(in_channels=hidden, hidden_size=64),
    )


def _quarter_refinement(feature_channels: int, channels: int) -> nn.Sequential:
    features = 3 * feature_channels
    logits = 2 * 4**2  # pixel_unshuffle by 4
    differences = 2 * DIFFERENCE_CHANNELS  # their maximum and mean
    return nn.Sequential(
        _conv(features + logits + differences + STATE_CHANNELS, channels, 1),
        *(_conv(channels, channels, 3) for _ in range(3)),
    )


def _half_refinement(feature_channels: int, channels: int) -> nn.Sequential:
    features = 3 * feature_channels
    pictures = 3 * (3 * 2**2)  # pixel_unshuffle by 2
    logits = 2 * 2**2
    inputs = features + pictures + logits + DIFFERENCE_CHANNELS + QUARTER_STATE_CHANNELS
    return nn.Sequential(
        _conv(inputs, channels, 1),
        _conv(channels, channels, 3),
        nn.Conv2d(channels, 2 * 2**2, 3, 1, 1),  # pixel_shuffle makes two masks of it
    )


def _conv(inputs: int, outputs: int, kernel: int) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(inputs, outputs, kernel, 1, kernel // 2), nn.ReLU())
