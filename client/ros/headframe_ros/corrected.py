"""SLAM's trajectory as it is after loop closures: which poses the robot gets of it, and where odometry lies in its frame.
Pure: no ROS, no clock, no thread."""

import numpy as np

from .messages import pose_of, stamp_s
from .topics import frame


class Corrected:
    """Takes nav_msgs/Path messages, of what the odometry moves, and gives them to the robot.

    Odometry in the path's own frame is taken for SLAM's own, which jumps where a loop is closed: scans go on at it as it is.
    In another frame it is taken to go on smoothly, and scans are laid where the newest pose of the path puts that frame.
    """

    def __init__(self, robot, pairing, least_moved_m=0.05, least_turned_rad=0.01):
        self.moved, self.warning = 0, ""  # keyframes, in all; of the last path
        self.frame = None  # the path's, from the first one on
        self._robot, self._pairing = robot, pairing
        self._least = least_moved_m, least_turned_rad
        self._T_path_odometry = np.eye(4)
        self._waits = robot.last_keyframe > 0  # in which frame its keyframes lie, only the path tells

    def scans(self, scans):
        """[(stamp_s, T_local_sensor, points, intensity)] where they lie in the session's frame."""
        if self._waits:
            self._pairing.lose("no corrected path yet", len(scans))
            return []
        return [(stamp, self._T_path_odometry @ T, *rest) for stamp, T, *rest in scans]

    def path(self, message, odometry_frame):
        """The whole trajectory as it is now. ValueError: it is none."""
        if not all(hasattr(pose, "header") for pose in getattr(message, "poses", [None])):
            raise ValueError("the corrected path is no nav_msgs/Path")
        stamps = np.array([stamp_s(pose.header) for pose in message.poses])
        self.warning = ""
        if len(stamps) == 0:
            return
        if (np.diff(stamps) <= 0).any():
            raise ValueError("the poses of the corrected path need stamps of their own that rise")
        T_path_base = np.array([pose_of(pose.pose) for pose in message.poses])
        T_base_sensor = self._pairing.mounting()
        if T_base_sensor is None:
            return  # no cloud has come
        self.frame = frame(message.header.frame_id)
        smooth = odometry_frame is not None and odometry_frame != self.frame
        moved, matched = self._robot.correct(stamps, T_path_base @ T_base_sensor, *self._least, later_ones=smooth)
        self.moved += len(moved)
        if matched == 0 and self._robot.last_keyframe > 0:
            self.warning = "the corrected path has no pose near the stamp of any keyframe"
        if smooth:
            self._lay_odometry(stamps, T_path_base)
        else:
            self._waits = False

    def _lay_odometry(self, stamps, T_path_base):
        """By the newest pose of the path whose odometry is known."""
        for stamp, T in zip(stamps[::-1], T_path_base[::-1]):
            T_odometry_base = self._pairing.pose_at(stamp)
            if T_odometry_base is not None:
                self._T_path_odometry, self._waits = T @ np.linalg.inv(T_odometry_base), False
                return
            if stamp < self._pairing.oldest_s():
                break
        self.warning = "the corrected path ends before the odometry that is kept"
