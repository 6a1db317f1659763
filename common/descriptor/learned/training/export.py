"""Writes the network as ONNX, as OpenCV's DNN module reads it."""
import copy

import torch
from torch.nn.utils.fusion import fuse_conv_bn_eval

from model import COLUMNS, ROWS, Ring


def export(net, file):
    still = copy.deepcopy(net).float().to(memory_format=torch.contiguous_format).eval()
    for ring in still.modules():
        if isinstance(ring, Ring):  # the norm of a network at rest is part of its convolution
            ring.conv, ring.norm = fuse_conv_bn_eval(ring.conv, ring.norm), torch.nn.Identity()
    torch.onnx.export(still, torch.zeros(1, 2, ROWS, COLUMNS), file, opset_version=11, input_names=["image"],
                      output_names=["q", "w", "junction"])
