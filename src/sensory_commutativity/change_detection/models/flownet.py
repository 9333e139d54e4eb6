"""FlowNet-S in the same role: two stacked pictures, down to a few pixels and up again, a prediction at every scale (Fischer et al. 2015)."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

CHANNELS = (64, 128, 256, 512, 512)
"""Of the original's first five levels."""


def _convolution(inputs: int, outputs: int, kernel: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, kernel, stride, (kernel - 1) // 2), nn.LeakyReLU(0.1)
    )


class MaskFlowNet(nn.Module):
    """FlowNet-S with the logits of two masks in place of flow.

    Its channels are the original's times `scale`, its sixth level, of 2 x 2 pixels here, is left out; `scale` 0.26 makes about as many parameters as
    :class:`.raft.MaskRaft` has. As in the original the finest prediction has a quarter of the resolution, and is brought to full size bilinearly.
    """

    def __init__(self, scale: float = 0.26):
        super().__init__()
        self.architecture = dict(scale=scale)
        wide = [max(8, round(channels * scale)) for channels in CHANNELS]
        self.down = nn.ModuleList(
            [
                _convolution(6, wide[0], 7, 2),
                _convolution(wide[0], wide[1], 5, 2),
                nn.Sequential(_convolution(wide[1], wide[2], 5, 2), _convolution(wide[2], wide[2])),
                nn.Sequential(_convolution(wide[2], wide[3], 3, 2), _convolution(wide[3], wide[3])),
                nn.Sequential(_convolution(wide[3], wide[4], 3, 2), _convolution(wide[4], wide[4])),
            ]
        )
        up, predict, below = [], [nn.Conv2d(wide[4], 2, 3, 1, 1)], wide[4]
        for level, outputs in ((3, 512), (2, 256), (1, 128)):
            rising = max(8, round(outputs * scale))
            up.append(nn.Sequential(nn.ConvTranspose2d(below, rising, 4, 2, 1), nn.LeakyReLU(0.1)))
            below = wide[level] + rising + 2
            predict.append(nn.Conv2d(below, 2, 3, 1, 1))
        self.up, self.predict = nn.ModuleList(up), nn.ModuleList(predict)
        self.rise = nn.ModuleList(nn.ConvTranspose2d(2, 2, 4, 2, 1) for _ in up)

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Pictures float (n, 3, h, w) in [-1, 1], sides divisible by 32: logits at every scale, coarse to fine, all brought to float (n, 2, h, w)."""
        levels, x = [], torch.cat([first, second], 1)
        for layer in self.down:
            x = layer(x)
            levels.append(x)
        logits = self.predict[0](x)
        found = [logits]
        for up, rise, predict, level in zip(
            self.up, self.rise, self.predict[1:], levels[-2:0:-1], strict=True
        ):
            x = torch.cat([level, up(x), rise(logits)], 1)
            logits = predict(x)
            found.append(logits)
        return [
            functional.interpolate(
                logits.float(), first.shape[2:], mode="bilinear", align_corners=False
            )
            for logits in found
        ]
