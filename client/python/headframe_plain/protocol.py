"""The robot's side of protocol v1 for one session, without sockets or a clock: bytes in, frames out.

Needs the generated messages (headframe/v1/robot_pb2.py): protoc -I proto --python_out=DIR headframe/v1/types.proto
headframe/v1/robot.proto, and DIR in PYTHONPATH.
"""

import re
import struct

from google.protobuf.message import DecodeError
from headframe.v1 import robot_pb2

VERSION = 1
MOST_FRAME_BYTES = 262144
MOST_CHUNK_BYTES = 8192
MOST_CLOUD_BYTES = 16 << 20
KEYFRAMES_ON_THEIR_WAY = 64
CLOUDS_ON_THEIR_WAY = 16
NO_NAME = re.compile("[/\x00-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
                     "\U000e0000-\U000e007f]")
POSES_IN_A_MESSAGE = 120  # about 8 KiB: a keyframe waits no longer for it
POSES_IN_AN_UPDATE = 100000
CAPABILITIES = ("cloud_refusal", "link_policy", "poses")


class LinkEnds(Exception):
    """The connection is to be closed. permanent: coming back with the same session will not help."""

    def __init__(self, why, permanent=False):
        super().__init__(why)
        self.permanent = permanent


def is_name(utf8):
    """Whether these bytes may name a robot, a session, a family or a sensor."""
    try:
        text = utf8.decode()
    except UnicodeDecodeError:
        return False
    return 1 <= len(utf8) <= 128 and text not in (".", "..") and not NO_NAME.search(text)


def frame(message):
    payload = message.SerializeToString()
    return struct.pack(">I", len(payload)) + payload


class FrameReader:
    """Takes bytes as they come; next() gives whole payloads, None while one is incomplete."""

    def __init__(self):
        self._buffer = bytearray()

    def feed(self, received):
        self._buffer += received

    def next(self):
        if len(self._buffer) < 4:
            return None
        (length,) = struct.unpack_from(">I", self._buffer)
        if not 1 <= length <= MOST_FRAME_BYTES:
            raise LinkEnds(f"a frame of {length} bytes was announced, 1 to {MOST_FRAME_BYTES} are allowed")
        if len(self._buffer) < 4 + length:
            return None
        payload = bytes(self._buffer[4:4 + length])
        del self._buffer[:4 + length]
        return payload


class Session:
    """What outlives a connection: the keyframes and the updates of their poses (all of them: a server that lost its database
    asks for them again), their clouds, and what the server said last. Not thread safe.

    cloud(sequence) gives a keyframe's encoded cloud, b"" if it has none. on_transforms(TransformUpdate) is called when a
    new revision comes.
    """

    def __init__(self, hello, cloud, on_transforms):
        self.hello, self.keyframes, self.durable = hello, [], 0
        self.updates, self.durable_update = [], 0  # (how many keyframes there were, {sequence: types_pb2.Pose})
        self.transforms, self.welcomed_once = None, False
        self._cloud, self._on_transforms = cloud, on_transforms
        self._durable_clouds = set()  # as the last Welcome and the acknowledgements since say
        self._gone = set()  # clouds that were refused or can not be encoded: they are never sent again
        self.credential = None  # token and code for the hello; None: in the clear
        self.disconnected()

    def disconnected(self):
        """A new connection begins: nothing of the last one holds."""
        self.welcomed, self.hold, self.cut = False, "", ""
        self.bytes_per_s = 0
        self._reader, self._answers = FrameReader(), []
        self._sent = self._sent_update = 0
        self._takes_poses, self._moving = False, None  # an update on its way: its number, its poses, how many are sent
        self._requested, self._transfer = [], None
        self._clouds_on_their_way, self._background_from = set(), 1
        self._asked = self._said_goodbye = False

    # ---- out

    def hello_frame(self):
        message = robot_pb2.RobotMessage()
        message.hello.CopyFrom(self.hello)
        if self.credential:
            message.hello.token = self.credential.token
            message.hello.enrolment_code = self.credential.code
        return frame(message)

    def next_frame(self):
        """The most urgent frame that may go now: answers, keyframes, clouds. None: nothing."""
        if not self.welcomed or self._said_goodbye:
            return None
        if self._answers:
            return self._answers.pop(0)
        if self.hold:
            return None
        if self._takes_poses and (self._moving or self._begin_update()):
            return self._next_poses()
        if self._sent < len(self.keyframes) and self._sent - self.durable < KEYFRAMES_ON_THEIR_WAY:
            return self._next_keyframe()
        return self._next_chunk()

    def trigger(self, reason):
        message = robot_pb2.RobotMessage()
        message.trigger.reason = reason
        self._answers.append(frame(message))

    def ping(self):
        """Once until something is heard."""
        if self.welcomed and not self._asked:
            self._asked = True
            message = robot_pb2.RobotMessage()
            message.ping.nonce = 1
            self._answers.append(frame(message))

    def goodbye(self):
        """The last frame of a session that is wholly acknowledged."""
        message = robot_pb2.RobotMessage()
        message.goodbye.complete = True
        self._said_goodbye = True
        return frame(message)

    def all_acknowledged(self):
        """Keyframes, where they lie now, if the server takes that, and what the policy says of clouds."""
        clouds = self.hello.clouds == robot_pb2.CLOUD_POLICY_ALL
        moved = self.durable_update == len(self.updates) or not self._takes_poses
        return (self.welcomed and self.durable == len(self.keyframes) and moved and not self._transfer and not self._requested and
                not self._clouds_on_their_way and (not clouds or self._next_background() is None))

    def _next_keyframe(self):
        message = robot_pb2.RobotMessage()
        message.keyframe.CopyFrom(self.keyframes[self._sent])
        self._sent += 1
        message.backlog = len(self.keyframes) - self._sent
        return frame(message)

    def _begin_update(self):
        """Those that wait and whose keyframes are all sent, as one: the newest pose of each keyframe. False: there is none."""
        last, poses = self._sent_update, {}
        while last < len(self.updates) and self.updates[last][0] <= self._sent:
            both = {**poses, **self.updates[last][1]}
            if poses and len(both) > POSES_IN_AN_UPDATE:
                break
            last, poses = last + 1, both
        if poses:
            self._moving = [last, sorted(poses.items()), 0]
        return bool(poses)

    def _next_poses(self):
        number, poses, offset = self._moving
        message = robot_pb2.RobotMessage()
        update, run = message.pose_update, None
        update.number, update.total_poses, update.offset = number, len(poses), offset
        for sequence, pose in poses[offset:offset + POSES_IN_A_MESSAGE]:
            if run is None or sequence != run.first + len(run.T_local_sensor):
                run = update.runs.add(first=sequence)
            run.T_local_sensor.append(pose)
        self._moving[2] += POSES_IN_A_MESSAGE
        if self._moving[2] >= len(poses):
            self._sent_update, self._moving = number, None
        return frame(message)

    def _next_background(self):
        """The first keyframe whose cloud is not there and not on its way; None: there is none."""
        while self._background_from <= self._sent:
            sequence = self._background_from
            there = (self._durable_clouds, self._clouds_on_their_way, self._gone)
            if self.keyframes[sequence - 1].point_count and not any(sequence in clouds for clouds in there):
                return sequence
            self._background_from += 1
        return None

    def _next_chunk(self):
        while not self._transfer and len(self._clouds_on_their_way) < CLOUDS_ON_THEIR_WAY:
            sequence = None
            if self._requested and self._requested[0] <= self._sent:
                sequence = self._requested.pop(0)
            elif self.hello.clouds == robot_pb2.CLOUD_POLICY_ALL:
                sequence = self._next_background()
            if sequence is None:
                return None
            encoded = self._cloud(sequence)
            if encoded and len(encoded) <= MOST_CLOUD_BYTES:
                self._transfer = [sequence, encoded, 0]
            else:
                return self._unavailable([sequence])
        return self._chunk() if self._transfer else None

    def _chunk(self):
        sequence, encoded, offset = self._transfer
        message = robot_pb2.RobotMessage()
        chunk = message.cloud_chunk
        chunk.sequence, chunk.total_bytes, chunk.offset = sequence, len(encoded), offset
        chunk.data = encoded[offset:offset + MOST_CHUNK_BYTES]
        self._transfer[2] += len(chunk.data)
        if self._transfer[2] == len(encoded):
            self._clouds_on_their_way.add(sequence)
            self._transfer = None
        return frame(message)

    def _unavailable(self, sequences):
        self._gone.update(sequences)
        message = robot_pb2.RobotMessage()
        message.submap_unavailable.sequences.extend(sequences)
        return frame(message)

    # ---- in

    def receive(self, received):
        """LinkEnds: the connection is to be closed."""
        self._reader.feed(received)
        while (payload := self._reader.next()) is not None:
            self._asked = False
            message = robot_pb2.ServerMessage()
            try:
                message.ParseFromString(payload)
            except DecodeError as fault:
                raise LinkEnds("a frame is no ServerMessage of protocol v1") from fault
            body = message.WhichOneof("body")
            if body is None:
                continue  # a body that a later server knows
            if not self.welcomed and body not in ("welcome", "error"):
                raise LinkEnds("a message before the welcome")
            getattr(self, f"_on_{body}")(getattr(message, body))

    def _on_welcome(self, welcome):
        if self.welcomed:
            raise LinkEnds("a second welcome")
        if welcome.protocol_version != VERSION:
            raise LinkEnds(f"the server speaks protocol {welcome.protocol_version}, this robot {VERSION}: update the older",
                           permanent=True)
        if welcome.durable_keyframes > len(self.keyframes):
            raise LinkEnds(f"the server holds {welcome.durable_keyframes} keyframes of this session, the robot made only "
                           f"{len(self.keyframes)}: begin a new session", permanent=True)
        if welcome.durable_pose_update > len(self.updates):
            raise LinkEnds(f"the server holds update {welcome.durable_pose_update} of this session's poses, the robot made only "
                           f"{len(self.updates)}: begin a new session", permanent=True)
        self.welcomed = self.welcomed_once = True
        self._takes_poses = "poses" in welcome.capabilities
        self._sent_update = self.durable_update = welcome.durable_pose_update
        self._sent = self.durable = welcome.durable_keyframes
        self._durable_clouds = {s for r in welcome.durable_clouds
                                for s in range(r.first, min(r.last, len(self.keyframes)) + 1)}
        if self.credential:
            self.credential.confirmed()

    def _on_keyframe_ack(self, ack):
        if ack.durable_keyframes > self._sent:
            raise LinkEnds("an acknowledgement of a keyframe that was not sent")
        self.durable = max(self.durable, ack.durable_keyframes)

    def _on_pose_update_ack(self, ack):
        if ack.durable_pose_update > self._sent_update:
            raise LinkEnds("an acknowledgement of an update of poses that was not sent")
        self.durable_update = max(self.durable_update, ack.durable_pose_update)

    def _on_cloud_ack(self, ack):
        for sequence in ack.sequences:
            self._clouds_on_their_way.discard(sequence)
            self._durable_clouds.add(sequence)

    def _on_cloud_refusal(self, refusal):
        self._clouds_on_their_way.discard(refusal.sequence)
        self._gone.add(refusal.sequence)
        if self._transfer and self._transfer[0] == refusal.sequence:
            self._transfer = None

    def _on_submap_request(self, request):
        never = self.hello.clouds == robot_pb2.CLOUD_POLICY_NEVER
        gone = []
        for sequence in request.sequences:
            known = 1 <= sequence <= len(self.keyframes) and self.keyframes[sequence - 1].point_count > 0
            if never or not known or sequence in self._gone:
                gone.append(sequence)
            elif sequence not in self._requested and sequence not in self._clouds_on_their_way and not (
                    self._transfer and self._transfer[0] == sequence):
                self._requested.append(sequence)
        if gone:
            self._answers.append(self._unavailable(gone))

    def _on_transform_update(self, update):
        known = self.transforms
        self.transforms = update
        if known is None or (known.revision, known.component) != (update.revision, update.component):
            self._on_transforms(update)

    def _on_link_policy(self, policy):
        self.hold, self.bytes_per_s, self.cut = policy.hold, policy.bytes_per_s, policy.cut

    def _on_ping(self, ping):
        message = robot_pb2.RobotMessage()
        message.pong.nonce = ping.nonce
        self._answers.insert(0, frame(message))

    def _on_pong(self, pong):
        pass

    def _on_error(self, error):
        raise LinkEnds(f"the server says: {error.message}", error.permanent)
