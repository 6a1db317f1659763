"""The few messages of ROS 2 that a robot is made of, out of their CDR encoding (OMG DDS-XTypes, plain CDR version 1)."""

import struct
from types import SimpleNamespace as Message


def decoded(kind, data):
    """ValueError: another kind, or not what it says."""
    readers = {"sensor_msgs/msg/PointCloud2": _point_cloud, "nav_msgs/msg/Odometry": _odometry,
               "geometry_msgs/msg/PoseStamped": _pose_stamped, "nav_msgs/msg/Path": _path, "tf2_msgs/msg/TFMessage": _transforms}
    if kind not in readers:
        raise ValueError(f"messages of {kind} are no clouds or poses")
    try:
        return readers[kind](_Reader(data))
    except (struct.error, UnicodeDecodeError, IndexError) as fault:
        raise ValueError(f"a message is no {kind}: {fault}") from None


class _Reader:
    """Each value is aligned to its size, counted from behind the header of four bytes."""

    def __init__(self, data):
        self._data, self._at = memoryview(data)[4:], 0
        self._order = "<" if data[1] & 1 else ">"

    def take(self, kind, count=1):
        size = struct.calcsize(kind)
        self._at += -self._at % size
        values = struct.unpack_from(f"{self._order}{count}{kind}", self._data, self._at)
        self._at += size * count
        return values if count > 1 else values[0]

    def bytes(self):
        length = self.take("I")
        if self._at + length > len(self._data):
            raise struct.error(f"{length} bytes are announced, {len(self._data) - self._at} are there")
        self._at += length
        return self._data[self._at - length:self._at]

    def text(self):
        return bytes(self.bytes()).rstrip(b"\0").decode()

    def many(self, one):
        return [one(self) for _ in range(min(self.take("I"), len(self._data)))]


def _header(r):
    return Message(stamp=Message(sec=r.take("i"), nanosec=r.take("I")), frame_id=r.text())


def _field(r):
    return Message(name=r.text(), offset=r.take("I"), datatype=r.take("B"), count=r.take("I"))


def _point_cloud(r):
    return Message(header=_header(r), height=r.take("I"), width=r.take("I"), fields=r.many(_field),
                   is_bigendian=r.take("B") != 0, point_step=r.take("I"), row_step=r.take("I"), data=r.bytes())


def _vector(r):
    return Message(**dict(zip("xyz", r.take("d", 3))))


def _quaternion(r):
    return Message(**dict(zip("xyzw", r.take("d", 4))))


def _pose(r):
    return Message(position=_vector(r), orientation=_quaternion(r))


def _pose_stamped(r):
    return Message(header=_header(r), pose=_pose(r))


def _path(r):
    return Message(header=_header(r), poses=r.many(_pose_stamped))


def _odometry(r):
    """Without what follows: covariance and twist."""
    return Message(header=_header(r), child_frame_id=r.text(), pose=Message(pose=_pose(r)))


def _transforms(r):
    return Message(transforms=r.many(lambda r: Message(
        header=_header(r), child_frame_id=r.text(), transform=Message(translation=_vector(r), rotation=_quaternion(r)))))
