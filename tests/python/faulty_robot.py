"""The plain Python client with a fault planted in it, to see that headframe-conformance finds it:

    python3 faulty_robot.py FAULT [options of headframe_plain]      FAULT "none" plants none; "list" prints them all
"""

import struct
import sys

import numpy as np
from headframe.v1 import robot_pb2
from headframe_plain import __main__ as command
from headframe_plain import cloud, descriptor, geometry, link, protocol, robot

FAULTS = {}


def fault(finding):
    """What headframe-conformance is to call it; the scenario is "session" unless said otherwise: "scenario/finding"."""

    def take(plant):
        FAULTS[plant.__name__.replace("_", "-")] = (plant, finding if "/" in finding else "session/" + finding)
        return plant

    return take


def replace(owner, name, make):
    """owner.name becomes make(what it was)."""
    setattr(owner, name, make(getattr(owner, name)))


def change_keyframe(change):
    def make(before):
        def keyframe(self, *args):
            message, sweeps = before(self, *args)
            change(self, message, args)
            return message, sweeps
        return keyframe
    replace(robot.Robot, "_keyframe", make)


def change_out(change):
    """change(session, RobotMessage) sees every frame that next_frame() gives."""
    def make(before):
        def next_frame(self):
            framed = before(self)
            if framed is None:
                return None
            message = robot_pb2.RobotMessage()
            message.ParseFromString(framed[4:])
            change(self, message)
            return protocol.frame(message)
        return next_frame
    replace(protocol.Session, "next_frame", make)


@fault("frame")
def length_little_endian():
    protocol.frame = lambda message: struct.pack("<I", message.ByteSize()) + message.SerializeToString()


@fault("tls")
def tls_1_2():
    def make(before):
        def context():
            made = before()
            made.minimum_version = made.maximum_version = link.ssl.TLSVersion.TLSv1_2
            return made
        return context
    replace(link, "tls_context", make)


@fault("version")
def protocol_version_2():
    robot.VERSION = 2


@fault("code")
def code_only_once():
    def make(before):
        def hello_frame(self):
            framed = before(self)
            self.credential.code = b""
            return framed
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("token")
def token_anew_each_time():
    def make(before):
        def hello_frame(self):
            self.credential.token = np.random.default_rng().bytes(32)
            return before(self)
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("spool-id")
def spool_id_anew_each_time():
    def make(before):
        def hello_frame(self):
            self.hello.spool_id += 1
            return before(self)
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("spool-runs")
def spool_run_anew_each_time():
    def make(before):
        def hello_frame(self):
            self.hello.spool_runs[0] += 1
            return before(self)
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("before-welcome")
def does_not_wait_for_the_welcome():
    def make(before):
        def hello_frame(self):
            ping = robot_pb2.RobotMessage()
            ping.ping.nonce = 1
            return before(self) + protocol.frame(ping)
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("another-server/pin")
def trusts_any_certificate():
    link.Link._check = lambda self, certificate: None


@fault("keyframe-field")
def sequences_from_0():
    def change(session, message):
        if message.HasField("keyframe"):
            message.keyframe.sequence -= 1
    change_out(change)


@fault("sequence")
def a_hole_in_the_sequence():
    def make(before):
        def next_keyframe(self):
            self._sent += self._sent == 20 and len(self.keyframes) > 21
            return before(self)
        return next_keyframe
    replace(protocol.Session, "_next_keyframe", make)


@fault("resume")
def goes_on_from_its_own_count():
    def make(before):
        def on_welcome(self, welcome):
            sent = max(getattr(self, "sent_ever", 0), welcome.durable_keyframes)
            before(self, welcome)
            self._sent = sent
        return on_welcome
    replace(protocol.Session, "_on_welcome", make)

    def count(before):
        def next_keyframe(self):
            framed = before(self)
            self.sent_ever = self._sent
            return framed
        return next_keyframe
    replace(protocol.Session, "_next_keyframe", count)


@fault("window")
def more_than_64_on_their_way():
    protocol.KEYFRAMES_ON_THEIR_WAY = 66


@fault("changed")
def a_keyframe_changes():
    def change(session, message):
        if message.HasField("keyframe"):
            message.keyframe.spaciousness_m *= 1 + 1e-4 * session.transforms_seen
    change_out(change)

    def make(before):
        def hello_frame(self):
            self.transforms_seen = getattr(self, "transforms_seen", -1) + 1
            return before(self)
        return hello_frame
    replace(protocol.Session, "hello_frame", make)


@fault("stamp")
def stamps_in_milliseconds():
    def change(self, keyframe, args):
        keyframe.stamp_s *= 1000
    change_keyframe(change)


@fault("pose")
def pose_the_wrong_way_round():
    def change(self, keyframe, args):
        T = geometry.inverse(args[1])
        p = keyframe.T_local_sensor
        p.x, p.y, p.z = T[:3, 3]
        p.qx, p.qy, p.qz, p.qw = geometry.quaternion(T[:3, :3])
    change_keyframe(change)


@fault("pose")
def quaternion_w_first():
    replace(geometry, "quaternion", lambda before: lambda R: np.roll(before(R), 1))


@fault("spaciousness")
def spaciousness_not_smoothed():
    def change(self, keyframe, args):
        keyframe.spaciousness_m = float(np.linalg.norm(args[2], axis=1).mean())
    change_keyframe(change)


@fault("walls")
def walls_not_levelled():
    def change(self, keyframe, args):
        keyframe.walls = descriptor.wall_profile(args[2])
    change_keyframe(change)


@fault("walls")
def walls_clockwise():
    def change(self, keyframe, args):
        keyframe.walls = keyframe.walls[::-1]
    change_keyframe(change)


@fault("walls")
def wall_codes_linear():
    descriptor.wall_code = lambda range_m: 0 if not range_m >= 0.3 else 1 + int(253 * min(range_m, 120) / 120)


@fault("walls")
def walls_the_nearest_point():
    before = np.sort
    replace(descriptor, "wall_profile", lambda original: lambda points: _with(
        np, "sort", lambda values: np.full_like(values, before(values)[0]), lambda: original(points)))


def _with(owner, name, value, act):
    before = getattr(owner, name)
    setattr(owner, name, value)
    try:
        return act()
    finally:
        setattr(owner, name, before)


@fault("q")
def halves_big_endian():
    replace(descriptor, "halves", lambda before: lambda values: np.frombuffer(before(values), "<f2").astype(">f2").tobytes())


@fault("descriptor-size")
def descriptor_in_32_bits():
    descriptor.halves = lambda values: np.asarray(values, "<f4").tobytes()


@fault("w")
def w_from_the_y_axis():
    def change(self, keyframe, args):
        keyframe.w = keyframe.w[30:] + keyframe.w[:30]
    change_keyframe(change)


@fault("cloud-frame")
def cloud_in_the_local_frame():
    def make(before):
        def keyframe(self, stamp, T, points):
            message, sweeps = before(self, stamp, T, points)
            return message, [(geometry.transform(T, np.array([o]))[0], geometry.transform(T, p)) for o, p in sweeps]
        return keyframe
    replace(robot.Robot, "_keyframe", make)


@fault("cloud-frame")
def morton_z_first():
    replace(cloud, "morton", lambda before: lambda offsets: before(offsets[:, ::-1]))


@fault("cloud-code")
def cloud_not_in_a_zstd_frame():
    cloud.zstd_of_raw_blocks = lambda data: data


@fault("cloud-form")
def intensities_for_a_server_that_does_not_read_them():
    def encode(sweeps, cell_m=0.01, form=1):
        painted = [(origin, points, [90] * len(points)) for origin, points in sweeps]
        return cloud.zstd_of_raw_blocks(cloud.content_with_intensity(painted, cell_m, form))
    cloud.encode = encode


@fault("point-count")
def points_of_the_last_sweep_only():
    def make(before):
        def keyframe(self, *args):
            message, sweeps = before(self, *args)
            message.point_count = len(sweeps[-1][1]) + 1
            return message, sweeps
        return keyframe
    replace(robot.Robot, "_keyframe", make)


@fault("chunk-size")
def chunks_of_9000_bytes():
    protocol.MOST_CHUNK_BYTES = 9000


@fault("chunk-offset")
def a_cloud_goes_on_where_the_link_broke():
    def make(before):
        def disconnected(self):
            half_sent = getattr(self, "_transfer", None)
            before(self)
            self._transfer = half_sent
        return disconnected
    replace(protocol.Session, "disconnected", make)


@fault("unasked-cloud")
def clouds_that_nobody_asked_for():
    def make(before):
        def next_chunk(self):
            if not self._requested and not self._transfer and self._sent > 3:
                self._requested.append(4)
            return before(self)
        return next_chunk
    replace(protocol.Session, "_next_chunk", make)


@fault("request-order")
def the_last_requested_first():
    def make(before):
        def on_submap_request(self, request):
            before(self, request)
            self._requested.reverse()
        return on_submap_request
    replace(protocol.Session, "_on_submap_request", make)


@fault("request")
def requests_are_not_answered():
    protocol.Session._on_submap_request = lambda self, request: None


@fault("pong")
def pings_are_not_answered():
    protocol.Session._on_ping = lambda self, ping: None


@fault("pong")
def pongs_without_the_nonce():
    replace(protocol.Session, "_on_ping", lambda before: lambda self, ping: before(self, robot_pb2.Ping(nonce=1)))


@fault("hold")
def does_not_hold():
    protocol.Session._on_link_policy = lambda self, policy: None


@fault("rate")
def sends_faster_than_it_may():
    def make(before):
        def on_link_policy(self, policy):
            before(self, robot_pb2.LinkPolicy(hold=policy.hold))
        return on_link_policy
    replace(protocol.Session, "_on_link_policy", make)


@fault("pong")
def an_unknown_body_ends_it():
    def make(before):
        def receive(self, received):
            if b"\xfa\x06\x02hi" in received:
                raise protocol.LinkEnds("a body that is not known", permanent=True)
            before(self, received)
        return receive
    replace(protocol.Session, "receive", make)


@fault("comes-back")
def gives_up_after_any_error():
    replace(protocol.LinkEnds, "__init__", lambda before: lambda self, why, permanent=False: before(self, why, True))


@fault("refused/came-back")
def comes_back_after_a_permanent_error():
    replace(protocol.LinkEnds, "__init__", lambda before: lambda self, why, permanent=False: before(self, why, False))


@fault("other-version/goes-on")
def goes_on_with_another_version():
    protocol.VERSION = 2


@fault("goodbye")
def goodbye_before_all_is_acknowledged():
    protocol.Session.all_acknowledged = lambda self: self.welcomed and self._sent == len(self.keyframes)


@fault("goodbye")
def leaves_without_a_goodbye():
    protocol.Session.goodbye = lambda self: b""


def main():
    name = sys.argv.pop(1)
    if name == "list":
        for known, (_, finding) in FAULTS.items():
            print(known, finding.replace("/", " "))
        return
    if name != "none":
        FAULTS[name][0]()
    command.main()


if __name__ == "__main__":
    main()
