"""The little of ONNX that the network `learned` needs, in numpy: a reader of its file, and a dozen operators.

For other networks take an ONNX runtime. Images are 1 x channels x rows x columns.
"""

import struct

import numpy as np


def _varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, at


def _fields(data):
    """(number, value) of a protobuf message: ints, or bytes of what is nested."""
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        kind = key & 7
        if kind == 0:
            value, at = _varint(data, at)
        elif kind == 2:
            size, at = _varint(data, at)
            value, at = data[at:at + size], at + size
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
            value, at = data[at:at + size], at + size
        else:
            raise ValueError("no ONNX file")
        yield key >> 3, value


def _all(data, number):
    return [value for field, value in _fields(data) if field == number]


def _ints(values):
    """Repeated integers, packed or not, with a sign."""
    out = []
    for value in values:
        at = 0
        while isinstance(value, bytes) and at < len(value):
            one, at = _varint(value, at)
            out.append(one)
        if isinstance(value, int):
            out.append(value)
    return [v - (1 << 64) if v >> 63 else v for v in out]


def _tensor(data):
    shape, kind = _ints(_all(data, 1)), _all(data, 2)[0]
    dtype = {1: "<f4", 7: "<i8"}[kind]
    raw = b"".join(_all(data, 9))
    values = np.frombuffer(raw, dtype) if raw else np.array(_ints(_all(data, 7)), dtype)
    return values.reshape(shape)


def _attribute(data):
    name = _all(data, 1)[0].decode()
    for field, value in _fields(data):
        if field == 2:
            return name, struct.unpack("<f", value)[0]
        if field == 3:
            return name, _ints([value])[0]
        if field == 5:
            return name, _tensor(value)
    return name, _ints(_all(data, 8))


def _convolved(x, weight, bias=0, strides=(1, 1), dilations=(1, 1), pads=(0, 0, 0, 0), **_):
    x = np.pad(x[0], ((0, 0), (pads[0], pads[2]), (pads[1], pads[3])))
    after, before, kernel_rows, kernel_columns = weight.shape
    rows = (x.shape[1] - dilations[0] * (kernel_rows - 1) - 1) // strides[0] + 1
    columns = (x.shape[2] - dilations[1] * (kernel_columns - 1) - 1) // strides[1] + 1
    out = np.zeros((after, rows * columns), np.float32)
    for i in range(kernel_rows):
        for j in range(kernel_columns):
            seen = x[:, i * dilations[0]:, j * dilations[1]:][:, ::strides[0], ::strides[1]][:, :rows, :columns]
            out += weight[:, :, i, j] @ seen.reshape(before, -1)
    return (out + np.reshape(bias, (-1, 1))).reshape(1, after, rows, columns)


def _sliced(x, starts, ends, axes, steps=None):
    index = [slice(None)] * x.ndim
    for k, axis in enumerate(axes):
        index[axis] = slice(starts[k], min(ends[k], x.shape[axis]), steps[k] if steps is not None else 1)
    return x[tuple(index)]


def _axes(of, x, axes=None, keepdims=1):
    return of(x, axis=tuple(axes), keepdims=bool(keepdims))


OPERATORS = {
    "Conv": _convolved, "Slice": _sliced,
    "Concat": lambda *parts, axis: np.concatenate(parts, axis),
    "Relu": lambda x: np.maximum(x, 0), "Add": np.add, "Mul": np.multiply, "Pow": np.power,
    "Constant": lambda value: value, "Identity": lambda x: x,
    "Flatten": lambda x, axis=1: x.reshape(int(np.prod(x.shape[:axis])), -1),
    "ReduceMean": lambda x, **how: _axes(np.mean, x, **how), "ReduceMax": lambda x, **how: _axes(np.max, x, **how),
    "Gemm": lambda a, b, c=0, alpha=1.0, beta=1.0, transA=0, transB=0: alpha * (a.T if transA else a) @ (
        b.T if transB else b) + beta * c,
}


class Network:
    def __init__(self, path):
        with open(path, "rb") as file:
            graph = _all(file.read(), 7)[0]
        self._weights = {_all(w, 8)[0].decode(): _tensor(w) for w in _all(graph, 5)}
        self._nodes = [([s.decode() for s in _all(n, 1)], _all(n, 2)[0].decode(), _all(n, 4)[0].decode(),
                        dict(_attribute(a) for a in _all(n, 5))) for n in _all(graph, 1)]
        self._input = [name for name in (_all(v, 1)[0].decode() for v in _all(graph, 11)) if name not in self._weights][0]
        self._outputs = [_all(v, 1)[0].decode() for v in _all(graph, 12)]
        missing = {operator for _, _, operator, _ in self._nodes} - set(OPERATORS)
        if missing:
            raise ValueError(f"{path} needs operators that are not here: {', '.join(sorted(missing))}")

    def run(self, image):
        """The outputs by name."""
        values = {**self._weights, self._input: np.asarray(image, np.float32)}
        for inputs, output, operator, attributes in self._nodes:
            values[output] = OPERATORS[operator](*(values[name] for name in inputs), **attributes)
        return {name: values[name].ravel() for name in self._outputs}
