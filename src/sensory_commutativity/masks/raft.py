"""RAFT with a head for two masks: its building blocks, other glue (Teed and Deng 2020; paper, section IV-A).

Flow has two channels, and so have two masks. The state that is refined is therefore the two masks' logits at an eighth of the resolution, from 0.
What differs from flow: masks live each in its own picture's frame, so correlations are looked up at the pixel itself, which does not move, once.
The second mask depends on the second picture as the first does on the first, so correlations and context are of both. And masks have sharp edges,
flow mostly not: after the last refinement one more, at half the resolution, looks at both pictures and their shallow features. One encoder serves
for features and context.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional
from torchvision.models.optical_flow._utils import upsample_flow
from torchvision.models.optical_flow.raft import (
    CorrBlock,
    FeatureEncoder,
    FlowHead,
    MaskPredictor,
    MotionEncoder,
    RecurrentBlock,
    ResidualBlock,
    UpdateBlock,
)

STRIDE = 8


class MaskRaft(nn.Module):
    """Two pictures to the logits of two masks, refined several times.

    Parameters
    ----------
    widths : tuple of int
        Channels of the encoders' five stages.
    hidden, context : int
        Channels of the recurrent state and of the context.
    levels, radius : int
        Of the correlation pyramid.
    updates : int
        Refinements at an eighth of the resolution.
    sharp : int
        Channels of the last one, at half of it.
    """

    def __init__(
        self, widths=(32, 32, 48, 64, 96), hidden: int = 64, context: int = 64, levels: int = 3, radius: int = 3, updates: int = 4, sharp: int = 40
    ):
        super().__init__()
        self.architecture = dict(widths=list(widths), hidden=hidden, context=context, levels=levels, radius=radius, updates=updates, sharp=sharp)
        self.hidden, self.updates = hidden, updates
        self.encoder = FeatureEncoder(block=ResidualBlock, layers=tuple(widths), strides=(2, 1, 2, 2), norm_layer=nn.InstanceNorm2d)
        self.begin = nn.Conv2d(widths[4], (hidden + context) // 2, 1)
        self.everywhere = nn.Conv2d(context, context, 1)
        self.correlation = CorrBlock(num_levels=levels, radius=radius)
        motion = MotionEncoder(in_channels_corr=2 * self.correlation.out_channels, corr_layers=(96, 64), flow_layers=(32, 16), out_channels=64)
        recurrent = RecurrentBlock(
            input_size=motion.out_channels + context, hidden_size=hidden, kernel_size=((1, 5), (5, 1)), padding=((0, 2), (2, 0))
        )
        self.update = UpdateBlock(motion_encoder=motion, recurrent_block=recurrent, flow_head=FlowHead(in_channels=hidden, hidden_size=96))
        self.upsampling = MaskPredictor(in_channels=hidden, hidden_size=96)
        self.told = nn.Conv2d(hidden, 16, 1)
        seen = 3 * widths[1] + 3 * 12 + 8 + 16  # shallow features, pictures, logits, what the state tells
        self.sharpening = nn.Sequential(
            nn.Conv2d(seen, sharp, 3, 1, 1), nn.ReLU(), nn.Conv2d(sharp, sharp, 3, 1, 1), nn.ReLU(), nn.Conv2d(sharp, 8, 3, 1, 1)
        )

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Pictures float (n, 3, h, w) in [-1, 1], sides divisible by 8 and at least 64: logits after each refinement, float (n, 2, h, w)."""
        n = len(first)
        pictures = torch.cat([first, second])
        shallow = self.encoder.layer1(self.encoder.convnormrelu(pictures))
        deep = self.encoder.conv(self.encoder.layer3(self.encoder.layer2(shallow)))
        correlations = self._correlations(*deep.float().chunk(2))
        half, both = self.hidden // 2, self.begin(deep).chunk(2)
        state = torch.tanh(torch.cat([part[:, :half] for part in both], 1))
        context = functional.relu(torch.cat([part[:, half:] for part in both], 1))
        context = context + self.everywhere(context.mean((2, 3), keepdim=True))  # another view is another view at every pixel
        logits = torch.zeros(n, 2, *deep.shape[2:], device=first.device)
        found = []
        for _ in range(self.updates):
            logits = logits.detach()
            state, change = self.update(state, context, correlations.to(state.dtype), logits.to(state.dtype))
            logits = logits + change.float()
            found.append(upsample_flow(logits / STRIDE, self.upsampling(state).float()))  # it multiplies by the stride, as flow wants it
        return [*found, found[-1] + self._sharpened(first, second, shallow, state, found[-1].detach())]

    def _correlations(self, one: Tensor, other: Tensor) -> Tensor:
        """Of every pixel's features with those around it in the other picture, both ways, in full precision: float (n, c, h, w)."""
        with torch.autocast(one.device.type, enabled=False):
            n, _, height, width = one.shape
            rows, columns = torch.meshgrid(torch.arange(height, device=one.device), torch.arange(width, device=one.device), indexing="ij")
            here = torch.stack([columns, rows]).float()[None].expand(n, -1, -1, -1)
            found = []
            for a, b in ((one, other), (other, one)):
                self.correlation.build_pyramid(a, b)
                found.append(self.correlation.index_pyramid(here))
        return torch.cat(found, 1)

    def _sharpened(self, first: Tensor, second: Tensor, shallow: Tensor, state: Tensor, logits: Tensor) -> Tensor:
        """What the last refinement adds to the logits: float (n, 2, h, w)."""
        one, other = shallow.chunk(2)
        a, b = (functional.pixel_unshuffle(picture, 2).to(shallow.dtype) for picture in (first, second))
        told = functional.interpolate(self.told(state), scale_factor=STRIDE // 2, mode="bilinear", align_corners=False)
        seen = [one, other, (one - other).abs(), a, b, (a - b).abs(), functional.pixel_unshuffle(logits, 2).to(shallow.dtype), told]
        return functional.pixel_shuffle(self.sharpening(torch.cat(seen, 1)).float(), 2)
