"""Clouds meet the poses of their stamps. Pure: no ROS, no clock, no thread."""

from bisect import bisect_left
from collections import deque

import numpy as np

from .messages import quaternion_of, rotation_of

KEPT_S = 30.0     # of odometry
MOST_GAP_S = 1.0  # between two poses of which one before and one after the cloud are asked
MOST_WAITING = 100


def between(T_a, T_b, share):
    """The pose at this share of the way: straight on, and about one axis."""
    a, b = quaternion_of(T_a[:3, :3]), quaternion_of(T_b[:3, :3])
    b = -b if a @ b < 0 else b
    angle = np.arccos(min(1.0, a @ b))
    q = (1 - share) * a + share * b if angle < 1e-6 else np.sin((1 - share) * angle) * a + np.sin(share * angle) * b
    T = np.eye(4)
    T[:3, :3] = rotation_of(*(q / np.linalg.norm(q)))
    T[:3, 3] = (1 - share) * T_a[:3, 3] + share * T_b[:3, 3]
    return T


class Pairing:
    """Takes odometry, mountings and clouds as they come, in any order within KEPT_S, and gives scans at their poses in the
    order of their clouds. At most MOST_WAITING clouds wait; then the oldest go. `lost` counts, by reason, those that went.
    """

    def __init__(self, T_base_sensor=None):
        """T_base_sensor: of every cloud. None: by static transforms from the odometry's moving frame to the cloud's."""
        self.lost = {}
        self._T_base_sensor = T_base_sensor
        self._mounted = {}  # frame -> {frame: T}
        self._stamps, self._poses = [], []
        self._base = self._sensor = None  # frames: of what moves, and of the last cloud
        self._waiting = deque()

    def static(self, parent, child, T_parent_child):
        self._mounted.setdefault(parent, {})[child] = T_parent_child
        self._mounted.setdefault(child, {})[parent] = np.linalg.inv(T_parent_child)

    def odometry(self, stamp_s, base, T_local_base):
        if self._stamps and stamp_s <= self._stamps[-1]:
            return self._lose("odometry that goes back in time")
        self._base = base
        self._stamps.append(stamp_s)
        self._poses.append(T_local_base)
        old = bisect_left(self._stamps, stamp_s - KEPT_S)
        if old > 1000:
            del self._stamps[:old], self._poses[:old]
        return None

    def cloud(self, stamp_s, frame, points, intensity=None):
        self._sensor = frame
        self._waiting.append((stamp_s, frame, points, intensity))
        if len(self._waiting) > MOST_WAITING:
            self._lose_oldest()

    def take(self):
        """[(stamp_s, T_local_sensor, points, intensity)] of the clouds whose odometry and mounting have come."""
        out = []
        while self._odometry_has_come():
            stamp_s, frame, points, intensity = self._waiting[0]
            T_base_sensor = self._mounting(frame)
            T_local_base = self.pose_at(stamp_s)
            if T_local_base is None:
                self._lose("no odometry near its stamp")
            elif T_base_sensor is None:
                break
            else:
                out.append((stamp_s, T_local_base @ T_base_sensor, points, intensity))
            self._waiting.popleft()
        return out

    def end(self):
        """No more comes: what waits is lost."""
        while self._waiting:
            self._lose_oldest()

    def _odometry_has_come(self):
        """For the cloud that has waited longest."""
        return self._waiting and self._stamps and self._waiting[0][0] <= self._stamps[-1]

    def _lose_oldest(self):
        frame = self._waiting[0][1]
        self._lose(f"no transform from {self._base} to {frame}" if self._odometry_has_come() else "no odometry came for it")
        self._waiting.popleft()

    def mounting(self):
        """T_base_sensor of the clouds that come; None: none has come, or nothing says where it is mounted."""
        return None if self._sensor is None else self._mounting(self._sensor)

    def oldest_s(self):
        """Of the odometry that is kept."""
        return self._stamps[0] if self._stamps else np.inf

    def lose(self, why, count):
        if count:
            self.lost[why] = self.lost.get(why, 0) + count

    def _lose(self, why):
        self.lose(why, 1)

    def pose_at(self, stamp_s):
        """T_local_base; None: no odometry is near this stamp."""
        after = bisect_left(self._stamps, stamp_s)
        if after == len(self._stamps):
            return None
        if self._stamps[after] == stamp_s:
            return self._poses[after]
        gap_s = self._stamps[after] - self._stamps[after - 1] if after > 0 else np.inf
        if gap_s > MOST_GAP_S:
            return None
        return between(self._poses[after - 1], self._poses[after], (stamp_s - self._stamps[after - 1]) / gap_s)

    def _mounting(self, frame):
        """Through any number of static transforms."""
        if self._T_base_sensor is not None:
            return self._T_base_sensor
        reached, queue = {self._base: np.eye(4)}, deque([self._base])
        while queue and frame not in reached:
            at = queue.popleft()
            for child, T in self._mounted.get(at, {}).items():
                if child not in reached:
                    reached[child] = reached[at] @ T
                    queue.append(child)
        return reached.get(frame)
