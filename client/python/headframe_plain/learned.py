"""The family `learned`: a network over a range image of the levelled scan."""

import numpy as np

from .onnx import Network

ROWS, COLUMNS, TOP_RAD = 16, 256, np.deg2rad(11.2)
TUNNEL, JUNCTION = 1, 2


def range_image(points_level):
    """ROWS x COLUMNS of metres, 0 without a return; small holes are filled."""
    r = np.linalg.norm(points_level, axis=1)
    row = np.floor((TOP_RAD - np.arcsin(np.clip(points_level[:, 2] / r, -1, 1))) * ROWS / (2 * TOP_RAD)).astype(int)
    inside = (row >= 0) & (row < ROWS)
    turn = np.arctan2(points_level[:, 1], points_level[:, 0]) / (2 * np.pi)
    column = (np.where(turn < 0, turn + 1, turn) * COLUMNS).astype(int) % COLUMNS
    pixel = (row * COLUMNS + column)[inside]
    count = np.bincount(pixel, minlength=ROWS * COLUMNS)
    logs = np.bincount(pixel, np.log(r[inside]), minlength=ROWS * COLUMNS)
    image = np.where(count > 0, np.exp(logs / np.maximum(count, 1)), 0).reshape(ROWS, COLUMNS)
    for column in range(COLUMNS):
        _bridge(image[:, column], 2, False)
    for row in range(ROWS):
        _bridge(image[row], 4, True)
    return image


def _bridge(line, longest, is_circle):
    """Fills holes of at most `longest` pixels, linearly in the logarithm."""
    seen = np.flatnonzero(line)
    if len(seen) < 2:
        return
    ends = np.append(seen[1:], seen[0] + len(line)) if is_circle else seen[1:]
    logs = np.log(line[seen])
    for k in np.flatnonzero((ends - seen[:len(ends)] > 1) & (ends - seen[:len(ends)] <= longest + 1)):
        gap, to = ends[k] - seen[k] - 1, logs[(k + 1) % len(seen)]
        for i in range(1, gap + 1):
            line[(seen[k] + i) % len(line)] = np.exp(logs[k] + i / (gap + 1) * (to - logs[k]))


class Learned:
    """A descriptor family. Under the open sky the robot library adds to q and w what this does not."""

    NAME, VERSION, Q_SIZE, W_SIZE = "learned", 2, 124, 64

    def __init__(self, path):
        """path: of learned.onnx, which is part of headframe."""
        self._network = Network(path)

    def describe(self, points_level):
        """q (124), w (64), place class. ValueError: nothing of the scan is where the network looks."""
        image = range_image(points_level)
        seen = image > 0
        if not seen.any():
            raise ValueError("no point of the scan lies within 11.2 deg of the horizon")
        ranges = np.where(seen, np.log(np.clip(image, 0.5, 60) / 5) / 1.5, 0)
        out = self._network.run(np.stack([ranges, seen])[np.newaxis])
        q = np.zeros(self.Q_SIZE)
        q[:64] = out["q"] / max(np.linalg.norm(out["q"]), 1e-6)
        return q, out["w"], JUNCTION if out["junction"][0] > 0 else TUNNEL
