"""The ROS 1 node of a robot: clouds and odometry go to the base station, the map's frame and what others know come back.
Parameters and topics: README.md."""

import sys
import threading

import headframe
import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from geometry_msgs.msg import PoseStamped, TransformStamped
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Empty
from tf2_msgs.msg import TFMessage

from .corrected import Corrected
from .messages import fill_transform
from .pairing import Pairing
from .replay import mounting_of
from .topics import Listener


class Feed:
    """ROS calls back on a thread for each topic; the robot gets scans one at a time, in order."""

    def __init__(self, robot, pairing, listener, corrected=None):
        self.scans = 0
        self.warning = ""
        self.T_local_sensor = None  # of the last scan
        self.corrected = corrected
        self._robot, self._pairing, self._listener = robot, pairing, listener
        self._pairs, self._feeds = threading.Lock(), threading.Lock()

    def hear(self, topic):
        return rospy.Subscriber(topic, self._kind(topic), lambda m: self._take(topic, m), queue_size=200)

    def hear_path(self, topic):
        return rospy.Subscriber(topic, Path, self._take_path, queue_size=1)

    @property
    def local_frame(self):
        """Of the session: the corrected path's, if there is to be one; None: not known yet."""
        return self.corrected.frame if self.corrected else self._listener.local_frame

    def _take_path(self, message):
        try:
            with self._feeds, self._pairs:
                self.corrected.path(message, self._listener.local_frame)
            if self.corrected.warning:
                raise ValueError(self.corrected.warning)
        except (ValueError, headframe.Error) as fault:
            self._warn(fault)

    def _warn(self, fault):
        self.warning = str(fault)
        rospy.logwarn_throttle(10, f"headframe: {fault}")

    def _kind(self, topic):
        if topic.startswith("/tf"):
            return TFMessage
        if topic == self._listener.topics[0]:
            return PointCloud2
        return PoseStamped if rospy.get_param("~poses", False) else Odometry

    def _take(self, topic, message):
        try:
            with self._pairs:
                self._listener.take(topic, message)
            with self._feeds:
                with self._pairs:
                    scans = self._pairing.take()
                    scans = self.corrected.scans(scans) if self.corrected else scans
                for scan in scans:
                    self.T_local_sensor = scan[1]
                    self.scans += 1
                    self._robot.add_scan(*scan)
        except (ValueError, headframe.Error) as fault:
            self._warn(fault)


class Told:
    """What the base station tells, as topics."""

    def __init__(self, robot, feed, map_frame):
        self._robot, self._feed, self._map_frame = robot, feed, map_frame
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._coverage = rospy.Publisher("~coverage", OccupancyGrid, queue_size=1, latch=True)
        self._map = rospy.Publisher("~map", PointCloud2, queue_size=1, latch=True)
        self._paths = {}
        robot.trajectories(self.paths)
        robot.coverage(self.coverage)

    def tf(self, _event=None):
        """The component's frame to the robot's local one, while the robot is on the map of others."""
        told, local = self._robot.transforms, self._feed.local_frame
        T = told.T_component_session.get(self._robot.session) if told and local else None
        if T is None:
            return
        out = TransformStamped(child_frame_id=local)
        out.header.stamp, out.header.frame_id = rospy.Time.now(), self._map_frame
        fill_transform(out.transform, T)
        self._tf.publish(TFMessage([out]))

    def paths(self, told):
        """One topic for each robot and session; in the robot's local frame."""
        for path in told.paths:
            name = "~paths/" + "".join(c if c.isalnum() else "_" for c in f"{path.session.robot}_{path.session.session}")
            if name not in self._paths:
                self._paths[name] = rospy.Publisher(name, Path, queue_size=1, latch=True)
            out = Path()
            out.header.frame_id = self._feed.local_frame or ""
            for x, y, z in path.points:
                at = PoseStamped(header=out.header)
                at.pose.position.x, at.pose.position.y, at.pose.position.z = x, y, z
                at.pose.orientation.w = 1
                out.poses.append(at)
            self._paths[name].publish(out)

    def coverage(self, told):
        """0 where somebody drove or saw free space, 100 where there is a wall, -1 where nobody has looked; in the map's frame."""
        middles, what, _, _ = told.cells() if told.told else (np.empty((0, 2)), np.empty(0, np.uint8), None, None)
        if len(what) == 0:
            return
        corner = middles.min(axis=0)
        column, row = np.round(middles - corner).astype(int).T
        cells = np.full((row.max() + 1, column.max() + 1), -1, np.int8)
        cells[row, column] = np.where(what & (headframe.FREE | headframe.PATH), 0, 100)
        out = OccupancyGrid()
        out.header.frame_id, out.header.stamp = self._map_frame, rospy.Time.now()
        out.info.resolution, out.info.height, out.info.width = 1.0, *cells.shape
        out.info.origin.position.x, out.info.origin.position.y = corner - 0.5
        out.info.origin.orientation.w = 1
        out.data = cells.ravel().tolist()
        self._coverage.publish(out)

    def map(self, told):
        if told.refused:
            rospy.logwarn_throttle(60, f"headframe: no map: {told.refused}")
            return
        out = PointCloud2(height=1, width=len(told.points), point_step=12, row_step=12 * len(told.points), is_dense=True)
        out.header.frame_id, out.header.stamp = self._feed.local_frame or "", rospy.Time.now()
        out.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
        out.data = np.asarray(told.points, "<f4").tobytes()
        self._map.publish(out)


def diagnostics(robot, feed, pairing):
    p = robot.progress
    level, text = DiagnosticStatus.OK, "connected"
    if not p.connected:
        level, text = DiagnosticStatus.WARN, "no link: what comes is kept in the spool"
    if p.cut:
        level, text = DiagnosticStatus.WARN, p.cut
    if p.hold:
        level, text = DiagnosticStatus.WARN, p.hold
    if feed.scans == 0:
        level, text = DiagnosticStatus.WARN, "no cloud has met a pose yet"
    if p.refused:
        level, text = DiagnosticStatus.ERROR, p.link_error
    values = {"scans": feed.scans, "keyframes": p.keyframes, "acknowledged": p.keyframes_acknowledged,
              "clouds waiting": p.clouds_waiting, "clouds dropped": p.clouds_dropped, "bytes sent": p.bytes_sent,
              "link": p.link_error, "last fault": feed.warning}
    if feed.corrected:
        values.update({"keyframes moved": feed.corrected.moved, "moves acknowledged": p.pose_updates_acknowledged})
    values.update({f"left out, {why}": count for why, count in pairing.lost.items()})
    status = DiagnosticStatus(level, "headframe", text, str(robot.session.robot),
                              [KeyValue(key, str(value)) for key, value in values.items()])
    out = DiagnosticArray(status=[status])
    out.header.stamp = rospy.Time.now()
    return out


def run(robot):
    param = rospy.get_param
    mounting = [float(v) for v in str(param("~mounting", "")).split()]
    if len(mounting) not in (0, 7):
        raise ValueError("~mounting: seven numbers, x y z qx qy qz qw")
    pairing = Pairing(mounting_of(mounting or None))
    local = param("~tf", "")
    listener = Listener(pairing, rospy.resolve_name("points"), None if local else rospy.resolve_name("odometry"), local or None)
    corrected = Corrected(robot, pairing, float(param("~least_moved", 0.05)), float(param("~least_turned", 0.01))) \
        if param("~corrected", False) else None
    feed = Feed(robot, pairing, listener, corrected)
    told = Told(robot, feed, param("~map_frame", "map"))
    health = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)
    radius_m = float(param("~map_radius", 0))

    def each_second(_event):
        health.publish(diagnostics(robot, feed, pairing))

    def ask_for_map(_event):
        if feed.T_local_sensor is not None:
            robot.map_around(feed.T_local_sensor[:3, 3], radius_m, 0.2, callback=told.map)

    subscribers = [feed.hear(topic) for topic in listener.topics]
    if corrected:
        subscribers.append(feed.hear_path(rospy.resolve_name("corrected")))
    subscribers.append(rospy.Subscriber("~merge", Empty, lambda _: robot.trigger("asked for on a topic"), queue_size=1))
    timers = [rospy.Timer(rospy.Duration(0.2), told.tf), rospy.Timer(rospy.Duration(1), each_second)]
    if radius_m > 0:
        timers.append(rospy.Timer(rospy.Duration(float(param("~map_every", 10))), ask_for_map))
    rospy.loginfo(f"headframe: {robot.session.robot}/{robot.session.session}, clouds on {listener.topics[0]}")
    rospy.spin()
    for one in subscribers:
        one.unregister()
    for timer in timers:
        timer.shutdown()


def main():
    rospy.init_node("headframe")
    param = rospy.get_param
    missing = [name for name in ("~server", "~robot", "~spool") if not param(name, "")]
    if missing:
        sys.exit(f"headframe: the parameter {missing[0]} is missing; see client/ros/README.md")
    try:
        with headframe.Robot(str(param("~robot")), spool=str(param("~spool")), server=str(param("~server")),
                             enrolment=str(param("~enrol", "")), insecure=bool(param("~insecure", False)),
                             family=str(param("~family", "learned")), clouds=str(param("~clouds", "all")),
                             bytes_per_s=float(param("~bytes_per_s", 0)),
                             intensity=bool(param("~intensity", True))) as robot:
            run(robot)
            robot.finish(float(param("~patience", 5)))
    except (ValueError, headframe.Error) as fault:
        sys.exit(f"headframe: {fault}")


if __name__ == "__main__":
    main()
