"""RAFT with a head for two masks: its building blocks, other glue (Teed and Deng 2020; paper, section IV-A).

Flow has two channels, and so have two masks. The state that is refined is therefore the two masks' logits at an eighth of the resolution, from 0.
What differs from flow: masks live each in its own picture's frame, so correlations are looked up at the pixel itself, which does not move, once.
The second mask depends on the second picture as the first does on the first, so correlations and context are of both. And masks have sharp edges,
flow mostly not: after the last refinement one more, at half the resolution, looks at both pictures' shallow features.
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
        self, widths=(32, 32, 48, 64, 96), hidden: int = 64, context: int = 64, levels: int = 3, radius: int = 3, updates: int = 4, sharp: int = 32
    ):
        super().__init__()
        self.architecture = dict(widths=list(widths), hidden=hidden, context=context, levels=levels, radius=radius, updates=updates, sharp=sharp)
        self.hidden, self.updates = hidden, updates
        encoder = dict(block=ResidualBlock, strides=(2, 1, 2, 2), norm_layer=nn.InstanceNorm2d)
        self.features = FeatureEncoder(layers=tuple(widths), **encoder)
        self.context = FeatureEncoder(layers=(*widths[:4], (hidden + context) // 2), **encoder)
        self.correlation = CorrBlock(num_levels=levels, radius=radius)
        motion = MotionEncoder(in_channels_corr=2 * self.correlation.out_channels, corr_layers=(96, 64), flow_layers=(32, 16), out_channels=64)
        recurrent = RecurrentBlock(
            input_size=motion.out_channels + context, hidden_size=hidden, kernel_size=((1, 5), (5, 1)), padding=((0, 2), (2, 0))
        )
        self.update = UpdateBlock(motion_encoder=motion, recurrent_block=recurrent, flow_head=FlowHead(in_channels=hidden, hidden_size=96))
        self.upsampling = MaskPredictor(in_channels=hidden, hidden_size=96)
        self.sharpening = nn.Sequential(
            nn.Conv2d(3 * widths[1] + 8, sharp, 3, 1, 1), nn.ReLU(), nn.Conv2d(sharp, sharp, 3, 1, 1), nn.ReLU(), nn.Conv2d(sharp, 8, 3, 1, 1)
        )

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Pictures float (n, 3, h, w) in [-1, 1], sides divisible by 8 and at least 64: logits after each refinement, float (n, 2, h, w)."""
        n, _, height, width = first.shape
        pictures = torch.cat([first, second])
        shallow = self.features.layer1(self.features.convnormrelu(pictures))
        deep = self.features.conv(self.features.layer3(self.features.layer2(shallow)))
        one, other = deep.float().chunk(2)
        rows, columns = torch.meshgrid(
            torch.arange(height // STRIDE, device=first.device), torch.arange(width // STRIDE, device=first.device), indexing="ij"
        )
        here = torch.stack([columns, rows]).float()[None].expand(n, -1, -1, -1)
        looked_up = []
        for a, b in ((one, other), (other, one)):
            self.correlation.build_pyramid(a, b)
            looked_up.append(self.correlation.index_pyramid(here))
        correlations = torch.cat(looked_up, 1)
        half = self.hidden // 2
        both = self.context(pictures).chunk(2)
        state = torch.tanh(torch.cat([part[:, :half] for part in both], 1))
        context = functional.relu(torch.cat([part[:, half:] for part in both], 1))
        logits = torch.zeros(n, 2, height // STRIDE, width // STRIDE, device=first.device)
        found = []
        for _ in range(self.updates):
            logits = logits.detach()
            state, change = self.update(state, context, correlations.to(state.dtype), logits.to(state.dtype))
            logits = logits + change.float()
            found.append(upsample_flow(logits / STRIDE, self.upsampling(state).float()))  # it multiplies by the stride, as flow wants it
        one, other = shallow.chunk(2)
        coarse = functional.pixel_unshuffle(found[-1].detach(), 2).to(shallow.dtype)
        found.append(found[-1] + functional.pixel_shuffle(self.sharpening(torch.cat([one, other, (one - other).abs(), coarse], 1)).float(), 2))
        return found
