"""What the base station tells as it happens: the little of WebSocket (RFC 6455) that a listener needs."""

import base64
import hashlib
import os
import struct
from typing import BinaryIO, Callable, Iterator, Tuple

from .exchange import Exchange
from .fault import Fault

SILENCE_S = 400.0  # the server sends a ping when it has told nothing for 150 s
LONGEST_EVENT = 64 * 1024 * 1024
_CONTINUES, _TEXT, _CLOSE, _PING, _PONG = 0, 1, 8, 9, 10
_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def events(exchange: Exchange) -> Iterator[dict]:
    """Each event as it comes; the first is a snapshot. Ends with a Fault, since a base station tells on for ever."""
    key = base64.b64encode(os.urandom(16))
    with exchange.connection(SILENCE_S) as connection:
        answer = exchange.answered(connection, "GET", "/api/v1/events", Connection="Upgrade", Upgrade="websocket",
                                   Sec_WebSocket_Version="13", Sec_WebSocket_Key=key.decode())
        accepted = base64.b64encode(hashlib.sha1(key + _GUID).digest()).decode()
        if answer.status != 101 or answer.getheader("Sec-WebSocket-Accept") != accepted:
            raise Fault("the server did not go over to telling events; is it a headframe-server?", answer.status)
        for text in _messages(answer.fp, connection.sock.sendall):
            yield exchange.decoded(text)


def _messages(source: BinaryIO, send: Callable[[bytes], None]) -> Iterator[bytes]:
    """Texts, put together from their frames, until the server closes; its pings are answered."""
    text = bytearray()
    while True:
        kind, last, payload = _frame(source)
        if kind == _CLOSE:
            raise Fault("the server ended the events: it stops, or the token ended")
        if kind == _PING:
            send(_masked(_PONG, payload))
        elif kind in (_TEXT, _CONTINUES):
            text += payload
            if len(text) > LONGEST_EVENT:
                raise Fault(f"an event is longer than {LONGEST_EVENT >> 20} MiB; is it a headframe-server?")
            if last:
                yield bytes(text)
                text.clear()


def _frame(source: BinaryIO) -> Tuple[int, bool, bytes]:
    """Its kind, whether a message ends with it, and what it holds."""
    first, second = _exactly(source, 2)
    size = second & 0x7F
    if size == 126:
        size, = struct.unpack(">H", _exactly(source, 2))
    elif size == 127:
        size, = struct.unpack(">Q", _exactly(source, 8))
    if second & 0x80 or first & 0x70 or size > LONGEST_EVENT:
        raise Fault("what the server tells is no event; is it a headframe-server?")
    return first & 0x0F, bool(first & 0x80), _exactly(source, size)


def _exactly(source: BinaryIO, size: int) -> bytes:
    read = source.read(size)
    if len(read) < size:
        raise Fault("the server broke off while it told events: ask again, a snapshot comes first")
    return read


def _masked(kind: int, payload: bytes) -> bytes:
    """A frame of a client's; of at most 125 bytes, as answers to pings are."""
    mask = os.urandom(4)
    payload = payload[:125]
    return bytes([0x80 | kind, 0x80 | len(payload)]) + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
