"""Protocol v1 over TCP and TLS, on a thread of its own; comes back when the link breaks."""

import hashlib
import random
import select
import socket
import ssl
import threading
import time

from .protocol import LinkEnds

CONNECT_S, WELCOME_S, PING_S, SILENCE_S, CLOSE_S = 5, 10, 10, 75, 5
RETRY_FIRST_S, RETRY_MOST_S = 0.5, 1.5


def tls_context():
    """TLS 1.3 and nothing older. Nothing of a certificate is looked at here: its fingerprint says all."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context


def split_address(address):
    host, _, port = address.rpartition(":")
    return host.strip("[]"), int(port)


class Link:
    """Carries a Session. All calls are thread safe; whoever uses the session meanwhile holds `lock`."""

    def __init__(self, session, server, fingerprint):
        """fingerprint: 32 bytes; None: in the clear."""
        self.session, self.lock = session, threading.Condition()
        self.last_error, self.refused = "", False
        self._server, self._fingerprint = server, fingerprint
        self._wake_out, self._wake_in = socket.socketpair()
        self._wake_out.setblocking(False)
        self._wake_in.setblocking(False)
        self._closing = self._complete = False
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self):
        self._thread.start()

    def wake(self):
        """The session has grown."""
        try:
            self._wake_out.send(b".")
        except BlockingIOError:
            pass  # it is awake

    def close(self, complete):
        """Says goodbye if all is acknowledged and `complete`, and ends the thread."""
        self._closing, self._complete = True, complete
        self.wake()
        self._thread.join()

    # ---- the thread

    def _run(self):
        wait_s = RETRY_FIRST_S
        while not self._closing and not self.refused:
            try:
                connection = self._connect()
                with connection:
                    self._serve(connection)
            except LinkEnds as end:
                self._failed(str(end), end.permanent)
            except OSError as fault:  # also ssl.SSLError
                self._failed(f"{self._server}: {fault}", False)
            with self.lock:
                if self.session.welcomed:
                    wait_s = RETRY_FIRST_S
                self.session.disconnected()
                self.lock.notify_all()
            if not self._closing and not self.refused:
                select.select([self._wake_in], [], [], 0)  # whoever woke us wants a connection, not a busy loop
                time.sleep(wait_s * random.uniform(0.5, 1))
                wait_s = min(2 * wait_s, RETRY_MOST_S)

    def _failed(self, why, permanent):
        with self.lock:
            self.last_error, self.refused = why, permanent
            self.lock.notify_all()

    def _connect(self):
        plain = socket.create_connection(split_address(self._server), CONNECT_S)
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if self._fingerprint is None:
            return plain
        try:
            secured = tls_context().wrap_socket(plain)
        except BaseException:
            plain.close()
            raise
        try:
            self._check(secured.getpeercert(binary_form=True))
        except BaseException:
            secured.close()
            raise
        return secured

    def _check(self, certificate):
        met = hashlib.sha256(certificate).digest()
        if met != self._fingerprint:
            raise LinkEnds(f"{self._server} is not the server that is pinned: its fingerprint is {met.hex()}")

    def _serve(self, connection):
        connection.setblocking(False)
        out = memoryview(self.session.hello_frame())
        began = heard = time.monotonic()
        not_before = 0.0
        while True:
            now = time.monotonic()
            received = self._read(connection)
            if received == b"":
                raise LinkEnds("the server closed the connection")
            with self.lock:
                if received:
                    heard = now
                    self.session.receive(received)
                    self.lock.notify_all()
                self._keep_time(now, began, heard)
                if not out and self._closing:
                    return self._end(connection)
                if not out and now >= not_before:
                    frame = self.session.next_frame()
                    out = memoryview(frame or b"")
                    if frame and self.session.bytes_per_s:
                        not_before = max(not_before, now) + len(frame) / self.session.bytes_per_s
            wrote = self._write(connection, out)
            out = out[wrote:]
            if received is None and not wrote:
                paced = 0.5 if now >= not_before else min(0.5, not_before - now)
                readable, _, _ = select.select([connection, self._wake_in], [connection] if out else [], [], paced)
                if self._wake_in in readable:
                    self._wake_in.recv(4096)

    def _keep_time(self, now, began, heard):
        if not self.session.welcomed and now - began > WELCOME_S:
            raise LinkEnds("the server did not answer the hello: is it a headframe server?")
        if now - heard > SILENCE_S:
            raise LinkEnds("the server fell silent")
        if now - heard > PING_S:
            self.session.ping()

    @staticmethod
    def _read(connection):
        """None: nothing has come; b"": the end of the stream."""
        try:
            return connection.recv(65536)
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return None

    @staticmethod
    def _write(connection, out):
        if not out:
            return 0
        try:
            return connection.send(out)
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return 0

    def _end(self, connection):
        """The goodbye, then the end of what is sent; the server closes."""
        connection.settimeout(CLOSE_S)
        if self._complete and self.session.all_acknowledged():
            connection.sendall(self.session.goodbye())
        connection.shutdown(socket.SHUT_WR)
        while connection.recv(65536):
            pass
