"""FlowNet-S that predicts two masks: an encoder of both pictures and a multi-scale decoder.

Fischer et al. 2015, "FlowNet: Learning Optical Flow with Convolutional Networks",
https://arxiv.org/abs/1504.06852. The comparison model beside RAFT.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

ENCODER_CHANNELS = (64, 128, 256, 512, 512)
"""Channels of the original's first five levels."""
DECODER_CHANNELS = (512, 256, 128)
"""Channels of the original's decoder from the fourth level to the second."""


class MaskFlowNet(nn.Module):
    """FlowNet-S with the logits of two masks in place of flow.

    The sixth level of the original, of 2 x 2 pixels here, is left out. As in the original, the
    finest prediction has a quarter of the resolution and is upsampled bilinearly.

    Parameters
    ----------
    scale : float
        Factor on the channels of the original; 0.26 gives about as many parameters as
        :class:`.raft.MaskRaft` has.
    """

    def __init__(self, scale: float = 0.26):
        super().__init__()
        self.architecture = dict(scale=scale)
        c1, c2, c3, c4, c5 = (max(8, round(channels * scale)) for channels in ENCODER_CHANNELS)
        self.down = nn.ModuleList(
            [
                _conv(6, c1, 7, 2),
                _conv(c1, c2, 5, 2),
                nn.Sequential(_conv(c2, c3, 5, 2), _conv(c3, c3)),
                nn.Sequential(_conv(c3, c4, 3, 2), _conv(c4, c4)),
                nn.Sequential(_conv(c4, c5, 3, 2), _conv(c5, c5)),
            ]
        )
        up: list[nn.Module] = []
        predict: list[nn.Module] = [nn.Conv2d(c5, 2, 3, 1, 1)]
        inputs = c5
        for skip, channels in zip((c4, c3, c2), DECODER_CHANNELS, strict=True):
            outputs = max(8, round(channels * scale))
            deconv = nn.ConvTranspose2d(inputs, outputs, 4, 2, 1)
            up.append(nn.Sequential(deconv, nn.LeakyReLU(0.1)))
            inputs = skip + outputs + 2  # skip connection, decoder, upsampled logits
            predict.append(nn.Conv2d(inputs, 2, 3, 1, 1))
        self.up = nn.ModuleList(up)
        self.predict = nn.ModuleList(predict)
        self.upsample_logits = nn.ModuleList(nn.ConvTranspose2d(2, 2, 4, 2, 1) for _ in up)

    def forward(self, first: Tensor, second: Tensor) -> list[Tensor]:
        """Predict the logits of both masks at every scale.

        Parameters
        ----------
        first, second : float (n, 3, h, w)
            Pictures in [-1, 1]; height and width are multiples of 32.

        Returns
        -------
        list of float32 (n, 2, h, w)
            From coarse to fine, all upsampled to the size of the pictures.
        """
        features = []
        x = torch.cat([first, second], 1)  # (n, 6, h, w)
        for layer in self.down:
            x = layer(x)
            features.append(x)  # (n, c, h / 2, w / 2) to (n, c, h / 32, w / 32)
        logits = self.predict[0](x)
        predictions = [logits]
        skips = features[-2:0:-1]
        for up, upsample, predict, skip in zip(
            self.up, self.upsample_logits, self.predict[1:], skips, strict=True
        ):
            x = torch.cat([skip, up(x), upsample(logits)], 1)
            logits = predict(x)
            predictions.append(logits)
        size = first.shape[2:]
        return [
            F.interpolate(prediction.float(), size, mode="bilinear", align_corners=False)
            for prediction in predictions
        ]


def _conv(inputs: int, outputs: int, kernel: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, kernel, stride, (kernel - 1) // 2), nn.LeakyReLU(0.1)
    )
