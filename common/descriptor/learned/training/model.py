"""The network: a range image in, a place vector q, a circular signature w and the junction class out."""
import torch
from torch import nn

ROWS, COLUMNS, Q, W = 16, 256, 64, 64


class RoundPad(torch.autograd.Function):
    """Columns are a circle. Autograd's own way back through the three parts costs as much as the convolutions."""

    @staticmethod
    def forward(context, x, by):
        context.by = by
        return torch.cat([x[..., -by:], x, x[..., :by]], 3)

    @staticmethod
    def backward(context, grad):
        by = context.by
        inner = grad[..., by:-by].clone(memory_format=torch.channels_last)
        inner[..., -by:] += grad[..., :by]
        inner[..., :by] += grad[..., -by:]
        return inner, None


def round_pad(x, by):
    """(F.pad's circular mode is exported wrongly to ONNX, without a word.)"""
    if by == 0:
        return x
    if torch.onnx.is_in_onnx_export():
        return torch.cat([x[..., -by:], x, x[..., :by]], 3)
    return RoundPad.apply(x, by)


class Ring(nn.Module):
    """A convolution that does not know where azimuth 0 is."""

    def __init__(self, before, after, kernel, stride=(1, 1), dilation=1, rows_padded=True):
        super().__init__()
        self.by = dilation * (kernel[1] // 2)
        padding = (kernel[0] // 2 if rows_padded else 0, 0)
        self.conv = nn.Conv2d(before, after, kernel, stride, padding, (1, dilation), bias=False)
        self.norm = nn.BatchNorm2d(after)

    def forward(self, x):
        return torch.relu(self.norm(self.conv(round_pad(x, self.by))))


class Learned(nn.Module):
    def __init__(self):
        super().__init__()
        self.eye = nn.Sequential(
            Ring(2, 32, (3, 5), (1, 2)), Ring(32, 48, (3, 3), (2, 1)), Ring(48, 64, (3, 3), (2, 1)),
            Ring(64, 96, (3, 3), (2, 2)), Ring(96, 128, (2, 3), rows_padded=False))
        self.around = nn.ModuleList(Ring(128, 128, (1, 3), dilation=d) for d in (1, 2, 4, 8, 16))
        self.w = nn.Conv2d(128, 1, 1)
        self.parts = nn.Conv2d(128, 192, 1)
        self.q = nn.Linear(384, Q)
        self.junction = nn.Sequential(nn.Linear(256, 32), nn.ReLU(), nn.Linear(32, 1))

    def forward(self, image):
        x = self.eye(image)
        for ring in self.around:
            x = x + ring(x)
        w = self.w(x).flatten(1)
        mean, most = x.mean((2, 3)), x.amax((2, 3))
        parts = torch.relu(self.parts(x)) + 1e-4
        sharp = (parts * parts * parts).mean((2, 3)) ** (1 / 3)  # generalised mean: between mean and most
        q = self.q(torch.cat([parts.mean((2, 3)), sharp], 1))
        if not torch.onnx.is_in_onnx_export():  # OpenCV 4.6 cannot divide a row by its length: the reader does
            q = nn.functional.normalize(q, dim=1)
        return q, w, self.junction(torch.cat([mean, most], 1))
