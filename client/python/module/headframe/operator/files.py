"""Files of what the base station knows; each is there as a whole, or not at all."""

import contextlib
import os
from typing import Generator

from .exchange import Exchange
from .fault import Fault

POINTS, PLANS = ("ply", "pcd", "las"), ("pdf", "svg", "png")
EXPORT_S = 3600.0  # the server counts all points before it sends the first
PIECE = 64 * 1024


def format_of(file: str, points: bool, plans: bool) -> str:
    """By the file's ending; `points` and `plans`: which of both fit what else is asked for."""
    form = os.path.splitext(file)[1][1:].lower()
    if form not in POINTS + PLANS:
        raise Fault(f"{file} ends in none of .ply, .pcd, .las, .pdf, .svg and .png; the ending chooses the format")
    if form in POINTS and not points:
        raise Fault(f"`scale` is of a plan (pdf, svg, png), and {file} is {form}: leave it out")
    if form in PLANS and not plans:
        raise Fault(f"`voxel_m` is of points (ply, pcd, las), and {file} is a plan: leave it out")
    return form


def download(exchange: Exchange, target: str, file: str, secret: bool = False) -> int:
    """How many bytes came. secret: nobody else may read the file."""
    part = file + ".part"
    try:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(part)  # of an earlier crash, with any mode
        with contextlib.closing(_pieces(exchange, target)) as pieces, \
                open(part, "xb", opener=lambda path, flags: os.open(path, flags, 0o600 if secret else 0o666)) as opened:
            for piece in pieces:
                opened.write(piece)
            opened.flush()
            os.fsync(opened.fileno())
            size = opened.tell()
        os.replace(part, file)
        return size
    except OSError as fault:
        raise Fault(f"cannot write {file}: {fault.strerror}") from fault
    finally:
        with contextlib.suppress(OSError):
            os.unlink(part)


def _pieces(exchange: Exchange, target: str) -> Generator[bytes, None, None]:
    with exchange.ask("GET", target, silence_s=EXPORT_S) as answer:
        while piece := answer.read(PIECE):
            yield piece
        exchange.check_whole(answer)
