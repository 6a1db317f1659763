#!/usr/bin/python3
"""Writes the small networks of network_test.cpp beside itself; needs python3-torch. Their values can be worked out by hand."""
import json
import pathlib

import torch

HERE = pathlib.Path(__file__).parent
SIDE = {"rows": 8, "columns": 64, "fov_up_deg": 20, "fov_down_deg": 20, "encoding": "range_m"}


class Plain(torch.nn.Module):
    """q: the mean of each row; w: of each column; a junction where the mean is above 5."""

    def forward(self, image):
        return image.mean(3).flatten(1), image.mean(2).flatten(1), image.mean((1, 2, 3)).reshape(1, 1) - 5


class WithoutW(torch.nn.Module):
    """q: the mean of each row of both channels."""

    def forward(self, image):
        return image.mean(3).flatten(1)


class OtherOutputs(torch.nn.Module):
    def forward(self, image):
        return image.mean(3).flatten(1), image.mean(2).flatten(1)


class NotFinite(torch.nn.Module):
    """q is the logarithm of each row's mean less 3 m."""

    def forward(self, image):
        return torch.log(image.mean(3).flatten(1) - 3)


class OfAVector(torch.nn.Module):
    def forward(self, image):
        return image * 2


class Unsupported(torch.nn.Module):
    """OpenCV's DNN module knows no NonZero."""

    def forward(self, image):
        return image.nonzero().float()


def write(name, net, image, outputs, side=None, **more):
    torch.onnx.export(net.eval(), image, str(HERE / f"{name}.onnx"), opset_version=11, input_names=["image"],
                      output_names=outputs, **more)
    if side:
        (HERE / f"{name}.onnx.json").write_text(json.dumps(side) + "\n")


one, two = torch.zeros(1, 1, 8, 64), torch.zeros(1, 2, 8, 64)
write("plain", Plain(), one, ["q", "w", "junction"], SIDE)
write("without_w", WithoutW(), two, ["q"], {**SIDE, "encoding": "log_range_mask"})
write("other_outputs", OtherOutputs(), one, ["features", "w"], SIDE)
write("not_finite", NotFinite(), one, ["q"], SIDE)
write("unsupported", Unsupported(), one, ["q"], SIDE)
write("of_a_vector", OfAVector(), torch.zeros(1, 64), ["q"], SIDE)
write("any_width", WithoutW(), two, ["q"], SIDE, dynamic_axes={"image": {3: "width"}})
