"""A base station in the hands of a Python program: what it knows, what an operator decides, what happens.

    from headframe.operator import BaseStation
    station = BaseStation("127.0.0.1:7448", token_file="headframe-data/operator.token")
    for session in station.sessions():
        print(session["robot"], session["keyframes"])

It needs Python's own library alone. What goes wrong is a Fault.
"""

from .base_station import BaseStation
from .fault import Fault

__all__ = ["BaseStation", "Fault"]
