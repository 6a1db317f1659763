"""One request to a base station over HTTP or HTTPS, and its answer."""

import contextlib
import http.client
import json
import socket
import ssl
from typing import Any, Iterator, Optional

from .access import Trust, find_token, find_trust, fingerprint_of, parse_address
from .fault import Fault

CONNECT_S = 5.0
LONGEST_ANSWER = 64 * 1024 * 1024


class Exchange:
    """Who to ask, and how. It holds no connection: each request has its own, so that threads may share it."""

    def __init__(self, address: str, token_file: Optional[str], fingerprint: Optional[str], authorities: Optional[str]) -> None:
        self._host, self._port, self._secure = parse_address(address)
        self._token = find_token(token_file)
        self._trust: Optional[Trust] = find_trust(fingerprint, authorities, token_file) if self._secure else None
        self._where = f"[{self._host}]:{self._port}" if ":" in self._host else f"{self._host}:{self._port}"

    @contextlib.contextmanager
    def ask(self, method: str, target: str, body: bytes = b"", silence_s: float = 60.0) -> Iterator[http.client.HTTPResponse]:
        """The answer, once its header is here; a Fault if it is a refusal, and if the server falls silent for so long."""
        with self.connection(silence_s) as connection:
            yield self.answered(connection, method, target, body)

    @contextlib.contextmanager
    def connection(self, silence_s: float) -> Iterator[http.client.HTTPConnection]:
        connection = http.client.HTTPConnection(self._host, self._port)
        connection.sock = self._connected()
        connection.sock.settimeout(silence_s)
        try:
            yield connection
        except TimeoutError as fault:
            raise Fault(f"the server at {self._where} does not answer; is it busy, or not headframe-server?") from fault
        except (OSError, http.client.HTTPException) as fault:
            raise Fault(f"the server at {self._where} broke off before its answer was complete ({fault!r}); look at its "
                        "log") from fault
        finally:
            connection.close()

    def answered(self, connection: http.client.HTTPConnection, method: str, target: str, body: bytes = b"",
                 **more: str) -> http.client.HTTPResponse:
        """`more` are fields of the header, with _ for -."""
        header = {"Host": self._where, "User-Agent": "headframe"}
        if self._token:
            header["Authorization"] = "Bearer " + self._token
        header.update((name.replace("_", "-"), value) for name, value in more.items())
        connection.request(method, target, body or None, header)
        answer = connection.getresponse()
        if answer.status >= 300:
            raise self._refusal(answer)
        return answer

    def read(self, answer: http.client.HTTPResponse) -> Any:
        """The JSON of the answer."""
        text = answer.read(LONGEST_ANSWER + 1)
        if len(text) > LONGEST_ANSWER:
            raise Fault(f"the answer of {self._where} is longer than {LONGEST_ANSWER >> 20} MiB; is it a headframe-server?")
        self.check_whole(answer)
        return self.decoded(text)

    def check_whole(self, answer: http.client.HTTPResponse) -> None:
        """Of one that was read to its end."""
        if answer.length:
            raise Fault(f"the server at {self._where} broke off before its answer was complete; look at its log")

    def decoded(self, text: bytes) -> Any:
        try:
            value = json.loads(text)
        except (ValueError, RecursionError):
            value = None
        if not isinstance(value, dict):
            raise Fault(f"the answer of {self._where} is not the JSON of headframe-server; is it another one?")
        return value

    def _refusal(self, answer: http.client.HTTPResponse) -> Fault:
        try:
            message = str(self.read(answer)["error"]["message"])
        except (Fault, KeyError, TypeError):
            message = f"{self._where} answers with HTTP status {answer.status} and no reason; is this a headframe-server?"
        return Fault(message, answer.status)

    def _connected(self) -> socket.socket:
        if self._trust is None:
            return self._reached()
        if self._trust.verified is not None:
            with contextlib.suppress(ssl.SSLCertVerificationError):
                return self._secured(self._trust.verified)
        stranger = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        stranger.minimum_version = ssl.TLSVersion.TLSv1_3
        stranger.check_hostname, stranger.verify_mode = False, ssl.CERT_NONE  # known by its fingerprint, or not at all
        secured = self._secured(stranger)
        met = fingerprint_of(secured.getpeercert(binary_form=True) or b"")
        if met in self._trust.pinned:
            return secured
        secured.close()
        if self._trust.verified is None:
            raise Fault(f"the server at {self._where} has another certificate than the one with the fingerprint that was given: "
                        f"is it another server? Its fingerprint is {met}")
        raise Fault(f"the server at {self._where} has a certificate that nobody known here vouches for. If its fingerprint, {met}, "
                    "is what headframe-server printed at its start, give it as `fingerprint`; or as `ca` the file of who vouches")

    def _reached(self) -> socket.socket:
        try:
            return socket.create_connection((self._host, self._port), CONNECT_S)
        except (OSError, UnicodeError) as fault:
            raise Fault(f"no headframe-server answers at {self._where} ({fault}); start it, or say where it is") from fault

    def _secured(self, context: ssl.SSLContext) -> ssl.SSLSocket:
        reached = self._reached()
        try:
            return context.wrap_socket(reached, server_hostname=self._host)
        except ssl.SSLCertVerificationError:
            reached.close()
            raise
        except (OSError, ValueError) as fault:
            reached.close()
            raise Fault(f"the server at {self._where} does not speak HTTPS ({fault}); where nobody listens on the way, "
                        f"http://{self._where} asks without") from fault
