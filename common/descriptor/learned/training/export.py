"""Writes the network as ONNX, as OpenCV's DNN module reads it."""
import copy

import torch

from model import COLUMNS, ROWS


def export(net, file):
    still = copy.deepcopy(net).float().to(memory_format=torch.contiguous_format).eval()
    torch.onnx.export(still, torch.zeros(1, 2, ROWS, COLUMNS), file, opset_version=11, input_names=["image"],
                      output_names=["q", "w", "junction"])
