"""The one exception of headframe.operator."""

from typing import Optional


class Fault(Exception):
    """What went wrong, where, and what to do, in a line for people.

    `status` is that of the server's answer (403: it is refused, 404: there is no such thing), None where none came.
    """

    def __init__(self, message: str, status: Optional[int] = None) -> None:
        super().__init__(message)
        self.status = status
