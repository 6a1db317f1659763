"""Plays a recorded session, as headframe-replay does: python3 -m headframe_plain --help."""

import argparse
import sys
import time

import numpy as np

from .credential import Refused
from .recording import Recording, read_trajectory
from .robot import POLICIES, Robot, Settings


def arguments():
    parser = argparse.ArgumentParser(prog="headframe_plain", description="Plays a recorded session as a robot.")
    parser.add_argument("--server", required=True, metavar="HOST:PORT")
    parser.add_argument("--robot", required=True)
    parser.add_argument("--credential", default="", help="file; without it ROBOT.credential here")
    parser.add_argument("--enrol", default="", help="what `headframe robot add` printed; needed the first time only")
    parser.add_argument("--insecure", action="store_true", help="in the clear, to a server that runs with --insecure")
    parser.add_argument("--clouds", default="on_request", choices=POLICIES)
    parser.add_argument("--cloud-form", type=int, default=1, choices=(1, 2))
    parser.add_argument("--network", default="", metavar="FILE",
                        help="learned.onnx: describe as the library's robots do, not with Scan Context")
    parser.add_argument("--corrected", default="", metavar="FILE",
                        help="TUM trajectory as SLAM has it at the end: keyframes whose stamps it has lie where it says")
    parser.add_argument("--rate", type=float, default=0, help="times real time; without it as fast as it goes")
    parser.add_argument("--linger", type=float, default=0, metavar="SECONDS",
                        help="stay until merged with another session, so long at most")
    parser.add_argument("--patience", type=float, default=30, metavar="SECONDS",
                        help="give up when nothing is acknowledged for so long")
    parser.add_argument("recording", metavar="SESSION_DIR")
    return parser.parse_args()


def told(robot, update):
    """One line for each other session: where its frame lies in mine."""
    for transform in update.sessions:
        other = transform.session.robot, transform.session.session
        if other != robot.name:
            T = robot.T_mine_other(*other)
            print(f"T_mine_{other[0]}", *(f"{v:.6f}" for v in T[:3].ravel()), flush=True)


def in_time(recording, rate):
    began, first = time.monotonic(), None
    for scan in recording:
        first = scan[0] if first is None else first
        if rate:
            time.sleep(max(0, began + (scan[0] - first) / rate - time.monotonic()))
        yield scan


def play(options):
    recording = Recording(options.recording)
    corrected = read_trajectory(options.corrected) if options.corrected else {}
    robot = Robot(Settings(
        server=options.server, robot=options.robot, enrolment=options.enrol, clouds=options.clouds,
        cloud_form=options.cloud_form, network=options.network, sensor=recording.sensor,
        credential="" if options.insecure else options.credential or f"{options.robot}.credential"))
    try:
        count = sum(robot.add_scan(*scan) for scan in in_time(recording, options.rate))
        if corrected:
            moved = {number: corrected[stamp_s] for number, stamp_s, T in robot.keyframes
                     if stamp_s in corrected and not np.allclose(corrected[stamp_s], T, rtol=0, atol=1e-9)}
            if moved:
                robot.update_poses(moved)
            print(f"{len(moved)} keyframes were moved by {options.corrected}", flush=True)
        robot.wait_acknowledged(options.patience)
        print(f"{count} keyframes, all acknowledged", flush=True)
        robot.trigger("all is sent")
        if options.linger:
            update = robot.wait_transforms(lambda update: len(update.sessions) > 1, options.linger)
            if update:
                told(robot, update)
    finally:
        robot.close()


def main():
    try:
        play(arguments())
    except (Refused, TimeoutError, OSError, ValueError) as fault:
        sys.exit(f"headframe_plain: {fault}")


if __name__ == "__main__":
    main()
