"""Which messages mean what: those of a bag, and those that a node hears."""

from .messages import pose_of, returns_of, stamp_s


class Listener:
    """Gives messages to a Pairing. Poses come from nav_msgs/Odometry or geometry_msgs/PoseStamped on `odometry`, or, with
    `local_frame`, from the tf transforms out of that frame."""

    def __init__(self, pairing, points, odometry=None, local_frame=None):
        self.topics = [points, "/tf_static"] + ([odometry] if odometry else ["/tf"])
        self.local_frame = local_frame
        self._pairing, self._points, self._odometry = pairing, points, odometry

    def take(self, topic, message):
        """ValueError: the message is no cloud or pose."""
        if topic == self._points:
            self._pairing.cloud(stamp_s(message.header), frame(message.header.frame_id), *returns_of(message))
        elif topic == "/tf_static":
            for t in message.transforms:
                self._pairing.static(frame(t.header.frame_id), frame(t.child_frame_id), pose_of(t.transform))
        elif topic == "/tf":
            for t in message.transforms:
                if frame(t.header.frame_id) == self.local_frame:
                    self._pairing.odometry(stamp_s(t.header), frame(t.child_frame_id), pose_of(t.transform))
        elif topic == self._odometry:
            self._take_pose(message)

    def _take_pose(self, message):
        self.local_frame = self.local_frame or frame(message.header.frame_id)
        inner = message.pose
        base = frame(getattr(message, "child_frame_id", "")) or "base_link"
        self._pairing.odometry(stamp_s(message.header), base, pose_of(inner.pose if hasattr(inner, "pose") else inner))


def frame(name):
    """Some write a slash before it."""
    return name.lstrip("/")
