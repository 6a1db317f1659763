"""Where the base station is, the operator's token, and whom to take for the right server."""

import hashlib
import ipaddress
import os
import re
import ssl
import stat
from pathlib import Path
from typing import FrozenSet, NamedTuple, Optional, Tuple

from .fault import Fault

DEFAULT_TOKEN_FILE = "headframe-data/operator.token"


class Trust(NamedTuple):
    """A server whose certificate has one of the fingerprints, or is vouched for by an authority of `verified`."""
    pinned: FrozenSet[str]
    verified: Optional[ssl.SSLContext]


def parse_address(text: str) -> Tuple[str, int, bool]:
    """Of [https://]HOST:PORT the host, the port, and whether HTTPS is spoken: without a word everywhere but on the loopback."""
    found = re.fullmatch(r"(https?://)?(\[[0-9A-Fa-f:.]+\]|[^\[\]:/@\s]+):(\d{1,5})/?", text)
    if not found or not 0 < int(found[3]) < 65536:
        raise Fault(f"{text!r} is no address of a base station; give HOST:PORT, with https:// or http:// before it or without")
    host = found[2].strip("[]")
    return host, int(found[3]), found[1] == "https://" or (found[1] is None and not _is_loopback(host))


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def find_token(file: Optional[str]) -> str:
    """Of the file, of $HEADFRAME_TOKEN, or of headframe-data/operator.token; empty where none of them is."""
    if not file and "HEADFRAME_TOKEN" in os.environ:
        token = os.environ["HEADFRAME_TOKEN"]
    else:
        try:
            with open(file or DEFAULT_TOKEN_FILE, encoding="ascii") as opened:
                if os.fstat(opened.fileno()).st_mode & (stat.S_IRWXG | stat.S_IRWXO):
                    raise Fault(f"{opened.name} can be used by others; take it from them: chmod 600 {opened.name}")
                token = opened.read(4096)
        except FileNotFoundError:
            if file:
                raise Fault(f"there is no token in {file}: give the server's DATA/operator.token, or a copy of it") from None
            return ""
        except (OSError, UnicodeDecodeError) as fault:
            raise Fault(f"the token in {file or DEFAULT_TOKEN_FILE} can not be read: {fault}") from fault
    token = token.strip()
    if not re.fullmatch(r"[\x21-\x7e]*", token):
        raise Fault("the operator's token is one word of letters and digits; is it another file?")
    return token


def find_trust(fingerprint: Optional[str], authorities: Optional[str], token_file: Optional[str]) -> Trust:
    """By the fingerprint; by the authorities of a PEM file; or by those of the system and the certificate beside the token."""
    if fingerprint and authorities:
        raise Fault("a fingerprint and a file of authorities are two ways to know the server: give one")
    if fingerprint:
        digits = fingerprint.replace(":", "").lower()
        if not re.fullmatch("[0-9a-f]{64}", digits):
            raise Fault("the fingerprint has 64 hexadecimal digits, as headframe-server prints them at its start")
        return Trust(frozenset([digits]), None)
    try:
        verified = ssl.create_default_context(cafile=authorities or None)
    except OSError as fault:
        raise Fault(f"the authorities of {authorities} can not be read: {fault}; give a PEM file") from fault
    verified.minimum_version = ssl.TLSVersion.TLSv1_3
    beside = Path(token_file or DEFAULT_TOKEN_FILE).parent / "identity.pem"
    return Trust(frozenset() if authorities else _fingerprint_in(beside), verified)


def _fingerprint_in(file: Path) -> FrozenSet[str]:
    try:
        found = re.search("-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", file.read_text(), re.DOTALL)
        return frozenset([fingerprint_of(ssl.PEM_cert_to_DER_cert(found[0]))]) if found else frozenset()
    except (OSError, ValueError):
        return frozenset()  # it is a help on the server's own machine, where it may be read


def fingerprint_of(certificate: bytes) -> str:
    return hashlib.sha256(certificate).hexdigest()
