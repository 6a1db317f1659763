"""Which scans become keyframes, and what the robot saw on the way to one."""

import numpy as np

from .geometry import angle_rad, inverse, transform

EPSILON = 1e-9
THIRTY_DEG = np.deg2rad(30)
KNOWN_AFTER_M, KNOWN_SPACING_M = 95, 20  # of path


def usable(points):
    """Without what is not finite or nearer than 0.1 m, which drivers write for "no return"."""
    points = np.asarray(points, float).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    return points[np.einsum("ij,ij->i", points, points) >= 0.1 * 0.1]


def mean_range(points):
    return float(np.linalg.norm(points, axis=1).mean()) if len(points) else 0.0


def keyframe_distance(spaciousness):
    for threshold in (10, 6, 3):
        if spaciousness > threshold:
            return threshold
    return max(spaciousness, 0.5)


def thinned(points, leaf=0.1):
    """The mean of the points in each cube of the grid."""
    if not len(points):
        return points
    _, cube, count = np.unique(np.floor(points / leaf).astype(int), axis=0, return_inverse=True, return_counts=True)
    return np.stack([np.bincount(cube, points[:, axis]) / count for axis in range(3)], axis=1)


class Selector:
    """Takes the scans of one session in order."""

    def __init__(self):
        self.spaciousness = 0.0
        self._poses = []
        self._path_m = 0.0
        self._path_m_of = []  # at each keyframe
        self._path_end = None

    def add(self, T_local_sensor, mean_range_m):
        """Whether the scan is a keyframe."""
        if mean_range_m > 0:
            first = self.spaciousness == 0
            self.spaciousness = mean_range_m if first else 0.9 * self.spaciousness + 0.1 * mean_range_m
        self._drive_to(np.array(T_local_sensor)[:3, 3])
        if not self._is_keyframe(T_local_sensor):
            return False
        self._poses.append(np.array(T_local_sensor))
        self._path_m_of.append(self._path_m)
        return True

    def restore(self, poses, spaciousness):
        """As if the keyframes had been chosen where they lie now."""
        self.spaciousness, self._path_m, self._path_end = spaciousness, 0.0, None
        self._poses, self._path_m_of = [], []
        for T in poses:
            self._drive_to(T[:3, 3])
            self._poses.append(np.array(T))
            self._path_m_of.append(self._path_m)

    def _drive_to(self, position):
        """In steps of a metre: a pose that trembles drives nowhere."""
        step = 1.0 if self._path_end is None else np.linalg.norm(position - self._path_end)
        if step < 1:
            return
        if self._path_end is not None:
            self._path_m += step
        self._path_end = position

    def _is_keyframe(self, T):
        if not self._poses:
            return True
        poses = np.array(self._poses)
        distance = np.linalg.norm(poses[:, :3, 3] - T[:3, 3], axis=1)
        is_near = distance < keyframe_distance(self.spaciousness) - EPSILON
        near = poses[is_near]
        if not len(near):
            return True
        since = self._path_m - np.array(self._path_m_of)
        if since[-1] >= KNOWN_SPACING_M - EPSILON and (since[is_near] >= KNOWN_AFTER_M - EPSILON).all():
            return True

        def turned(other):
            return angle_rad(other[:3, :3].T @ T[:3, :3]) >= THIRTY_DEG - EPSILON

        return turned(self._poses[-1]) and all(turned(other) for other in near)


class Sweeps:
    """Thinned scans between two keyframes. Holds 16 at most; when full the oldest goes."""

    def __init__(self):
        self._kept = []
        self._last = None

    def add(self, T_local_sensor, points):
        if self._last is not None:
            moved = inverse(self._last) @ T_local_sensor
            if np.linalg.norm(moved[:3, 3]) < 1 - EPSILON and angle_rad(moved[:3, :3]) < THIRTY_DEG - EPSILON:
                return
        self._kept = self._kept[-15:] + [(T_local_sensor, thinned(points))]
        self._last = T_local_sensor

    def take(self, T_local_keyframe, own_scan):
        """The keyframe's cloud in its own sensor frame: a list of (origin, points), its own scan last."""
        cloud = []
        for T_local_sensor, points in self._kept:
            T = inverse(T_local_keyframe) @ T_local_sensor
            if np.linalg.norm(T[:3, 3]) >= 1 - EPSILON:
                cloud.append((T[:3, 3], transform(T, points)))
        self._kept, self._last = [], T_local_keyframe
        return cloud + [(np.zeros(3), thinned(own_scan))]
