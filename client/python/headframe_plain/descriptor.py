"""Wall profile and Scan Context of a scan in the levelled frame: points (n, 3) in metres."""

import numpy as np

FEWEST_POINTS = 50


class ScanContext:
    """A descriptor family; headframe_plain.learned.Learned is another."""

    NAME, VERSION, Q_SIZE, W_SIZE = "scan_context", 1, 60, 60

    def describe(self, points_level):
        """q, w and the place class, which is not known."""
        return (*scan_context(points_level), 0)


def _sector(points, sectors):
    turn = np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi)
    return np.minimum((np.where(turn < 0, turn + 1, turn) * sectors).astype(int), sectors - 1)


def wall_code(range_m):
    """0 for nothing, else 1 to 254."""
    if not range_m >= 0.3:
        return 0
    return 1 + int(253 * np.log(min(range_m, 120) / 0.3) / np.log(120 / 0.3) + 0.5)


def wall_profile(points_level):
    """180 bytes: the code of the median distance in each sector of 2 deg."""
    r = np.hypot(points_level[:, 0], points_level[:, 1])
    near_horizon = (r >= 0.3) & (np.abs(points_level[:, 2]) <= 0.0787 * r)
    sectors, r = _sector(points_level[near_horizon], 180), r[near_horizon]
    profile = bytearray(180)
    for sector in np.unique(sectors):
        ranges = np.sort(r[sectors == sector])
        profile[sector] = wall_code(ranges[len(ranges) // 2])
    return bytes(profile)


def scan_context(points_level):
    """q (60) and w (60)."""
    r = np.hypot(points_level[:, 0], points_level[:, 1])
    points, r = points_level[r < 40], r[r < 40]
    cell = np.minimum((20 * np.sqrt(r / 40)).astype(int), 19) * 60 + _sector(points, 60)
    low, high = np.full(20 * 60, np.inf), np.full(20 * 60, -np.inf)
    np.minimum.at(low, cell, points[:, 2])
    np.maximum.at(high, cell, points[:, 2])
    seen = np.isfinite(low)
    height = np.zeros(20 * 60)
    height[seen] = high[seen] - low[seen]
    height, seen = height.reshape(20, 60), seen.reshape(20, 60)
    mean = height.mean(axis=1)
    spread = np.sqrt(np.maximum(0, (height * height).mean(axis=1) - mean * mean))
    q = np.stack([mean, spread, seen.mean(axis=1)], axis=1).ravel()
    return q, height.mean(axis=0)


def halves(values):
    """Little-endian binary16, rounded to nearest even. ValueError: one does not fit."""
    with np.errstate(over="ignore"):
        h = np.asarray(values, np.float32).astype("<f2")
    if not np.isfinite(h).all():
        raise ValueError("a number of a descriptor does not fit into binary16")
    return h.tobytes()


def halves_of_q(values):
    """As halves(), without the zeros at the end, but for the first number."""
    out = halves(values)
    while len(out) > 2 and out.endswith(b"\0\0"):
        out = out[:-2]
    return out
