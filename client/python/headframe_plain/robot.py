"""What a robot's developer uses: scans with poses in, the transforms of the component out."""

import secrets
import time
from dataclasses import dataclass, field

import numpy as np
from headframe.v1 import robot_pb2, types_pb2

from . import cloud, descriptor, geometry, keyframes
from .credential import Credential, Refused
from .learned import Learned
from .link import Link
from .protocol import CAPABILITIES, POSES_IN_AN_UPDATE, VERSION, Session, is_name

POLICIES = {"on_request": robot_pb2.CLOUD_POLICY_ON_REQUEST, "all": robot_pb2.CLOUD_POLICY_ALL,
            "never": robot_pb2.CLOUD_POLICY_NEVER}


def message_of(T):
    quaternion = geometry.quaternion(T[:3, :3])
    return types_pb2.Pose(**dict(zip(("x", "y", "z"), T[:3, 3])), **dict(zip(("qx", "qy", "qz", "qw"), quaternion)))


@dataclass
class Settings:
    server: str  # HOST:PORT
    robot: str
    credential: str = ""  # file, made with the enrolment; empty: in the clear, to a server with --insecure
    enrolment: str = ""  # what `headframe robot add` printed; only its first use counts
    session: str = ""  # empty: a random name
    clouds: str = "on_request"  # or all, never
    cloud_form: int = 1  # 2 is half as large and costs much more of the processor
    network: str = ""  # file learned.onnx: describe with the family "learned", which the library's robots use
    sensor: dict = field(default_factory=dict)  # model, beams, fov_up_deg, fov_down_deg, max_range_m


class Robot:
    """One session. Keyframes are kept in memory only: a robot that is started anew begins a new session.

    add_scan() and update_poses() from one thread at a time; all else is thread safe. `on_transforms(TransformUpdate)` is called on the
    link's thread, with its lock held: it must not call the robot. Refused: what can not be helped by trying again.
    """

    def __init__(self, settings, on_transforms=lambda update: None):
        for name in (settings.robot, settings.session or "-"):
            if not is_name(name.encode()):
                raise Refused(f"{name!r} is no name: 1 to 128 bytes that print, without '/'")
        self._settings = settings
        self._family = Learned(settings.network) if settings.network else descriptor.ScanContext()
        self._selector, self._sweeps, self._clouds = keyframes.Selector(), keyframes.Sweeps(), []
        self._last_stamp = -np.inf
        self._now = []  # where keyframes lie
        credential = Credential(settings.credential, settings.robot, settings.enrolment) if settings.credential else None
        self._session = Session(self._hello(), self._encoded_cloud, on_transforms)
        self._session.credential = credential
        self._link = Link(self._session, settings.server, credential.fingerprint if credential else None)
        self._link.start()

    @property
    def name(self):
        """(robot, session)."""
        return self._session.hello.session.robot, self._session.hello.session.session

    def add_scan(self, stamp_s, T_local_sensor, points_sensor):
        """One scan in the sensor frame with the sensor's pose (4x4). True: it became a keyframe. Stamps go up."""
        points = keyframes.usable(points_sensor)
        if stamp_s <= self._last_stamp or not np.isfinite(T_local_sensor).all() or not len(points):
            return False
        T = np.array(T_local_sensor, float)
        if len(points) < descriptor.FEWEST_POINTS or not self._selector.add(T, keyframes.mean_range(points)):
            self._sweeps.add(T, points)
            return False
        self._last_stamp = stamp_s
        keyframe, sweeps = self._keyframe(stamp_s, T, points)
        with self._link.lock:
            self._clouds.append(sweeps)
            keyframe.sequence = len(self._clouds)
            self._session.keyframes.append(keyframe)
        self._now.append(T)
        self._link.wake()
        return True

    def update_poses(self, T_local_sensor):
        """SLAM moved the past: where these keyframes lie now, {number: 4x4}, numbered from 1 in the order in which add_scan()
        said True. From the thread that calls add_scan(), which goes on in the frame as it is now. A server that is too old
        for it is told nothing. ValueError: no such keyframe, no pose, or none at all."""
        moved = {int(sequence): np.array(T, float) for sequence, T in T_local_sensor.items()}
        if not 1 <= len(moved) <= POSES_IN_AN_UPDATE:
            raise ValueError(f"{len(moved)} poses, an update has 1 to {POSES_IN_AN_UPDATE}")
        for sequence, T in moved.items():
            if not 1 <= sequence <= len(self._now):
                raise ValueError(f"there is no keyframe {sequence}")
            if not geometry.is_pose(T):
                raise ValueError(f"what is given for keyframe {sequence} is no pose")
        for sequence, T in moved.items():
            self._now[sequence - 1] = T
        self._selector.restore(self._now, self._session.keyframes[-1].spaciousness_m)
        self._sweeps.take(self._now[-1], np.empty((0, 3)))
        with self._link.lock:
            self._session.updates.append((len(self._now), {s: message_of(T) for s, T in moved.items()}))
        self._link.wake()

    @property
    def keyframes(self):
        """(number, stamp_s, 4x4 as it lies now) of each."""
        return [(k.sequence, k.stamp_s, T) for k, T in zip(self._session.keyframes, self._now)]

    def trigger(self, reason):
        """Asks the server to merge now."""
        with self._link.lock:
            self._session.trigger(reason)
        self._link.wake()

    def wait_acknowledged(self, patience_s=30):
        """Until the server has all keyframes (and with "all" their clouds) on its disk. Refused; TimeoutError: nothing was
        acknowledged for so long."""
        with self._link.lock:
            last, until = None, 0.0
            while not self._session.all_acknowledged():
                if self._link.refused:
                    raise Refused(self._link.last_error)
                durable = self._session.durable, self._session.durable_update
                if durable != last:
                    last, until = durable, time.monotonic() + patience_s
                if not self._link.lock.wait(max(0, until - time.monotonic())) and time.monotonic() >= until:
                    raise TimeoutError(self._link.last_error or "the server acknowledges nothing")

    def wait_transforms(self, condition, patience_s):
        """Until condition(TransformUpdate) holds; None: it did not within patience_s."""
        with self._link.lock:
            self._link.lock.wait_for(
                lambda: self._link.refused or (self._session.transforms and condition(self._session.transforms)),
                patience_s)
            update = self._session.transforms
            return update if update and condition(update) else None

    def T_mine_other(self, robot, session=None):
        """The other session's frame in mine, 4x4; None: they are not merged. Without a session any of that robot."""
        placed = {}
        with self._link.lock:
            for transform in self._session.transforms.sessions if self._session.transforms else []:
                p = transform.T_component_session
                placed[transform.session.robot, transform.session.session] = geometry.pose(
                    [p.x, p.y, p.z], [p.qx, p.qy, p.qz, p.qw])
        for (name, other), T in placed.items():
            if name == robot and session in (None, other) and self.name in placed:
                return geometry.inverse(placed[self.name]) @ T
        return None

    def close(self):
        """Says goodbye if all is acknowledged. The last call."""
        self._link.close(complete=True)

    # ---- what the link asks for

    def _hello(self):
        s = self._settings
        return robot_pb2.Hello(
            protocol_version=VERSION,
            session=types_pb2.SessionKey(robot=s.robot, session=s.session or secrets.token_hex(8)),
            sensor=types_pb2.Sensor(**{"model": "unknown", **s.sensor}),
            family=types_pb2.Family(name=self._family.NAME, version=self._family.VERSION, q_size=self._family.Q_SIZE,
                                    w_size=self._family.W_SIZE),
            clouds=POLICIES[s.clouds], software="headframe_plain (Python) 0.1.0",
            spool_id=secrets.randbits(63) | 1, spool_runs=[secrets.randbits(63) | 1], capabilities=CAPABILITIES)

    def _keyframe(self, stamp_s, T, points):
        points_level = geometry.levelled(T, points)
        q, w, place_class = self._family.describe(points_level)
        sweeps = self._sweeps.take(T, points)
        count = sum(len(sweep) for _, sweep in sweeps) if self._settings.clouds != "never" else 0
        return types_pb2.Keyframe(
            stamp_s=stamp_s, spaciousness_m=self._selector.spaciousness, q=descriptor.halves_of_q(q),
            T_local_sensor=message_of(T), w=descriptor.halves(w), walls=descriptor.wall_profile(points_level),
            point_count=count, place_class=place_class), [
                (origin.astype(np.float32), sweep.astype(np.float32)) for origin, sweep in sweeps]

    def _encoded_cloud(self, sequence):
        return cloud.encode(self._clouds[sequence - 1], form=self._settings.cloud_form)
