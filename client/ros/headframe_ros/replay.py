"""Plays a bag of ROS 1 or ROS 2 through the robot library, as the robot would have.

    python3 -m headframe_ros.replay --server HOST:PORT --robot NAME --enrol hf1-... --points /velodyne_points --odometry /odom BAG
"""

import argparse
import sys
import threading
import time

import headframe
import numpy as np

from .bags import messages
from .corrected import Corrected
from .messages import rotation_of
from .pairing import Pairing
from .topics import Listener


def arguments():
    parser = argparse.ArgumentParser(prog="headframe_ros.replay", description=__doc__.split("\n")[0])
    parser.add_argument("--server", required=True, help="base station, HOST:PORT; after a comma those that stand by for it")
    parser.add_argument("--robot", required=True, help="name of the robot")
    parser.add_argument("--enrol", default="", help="what `headframe robot add NAME` printed; needed the first time only")
    parser.add_argument("--spool", required=True, help="directory that keeps the session; one that was broken off goes on")
    parser.add_argument("--points", required=True, help="topic of sensor_msgs/PointCloud2")
    poses = parser.add_mutually_exclusive_group(required=True)
    poses.add_argument("--odometry", help="topic of nav_msgs/Odometry or geometry_msgs/PoseStamped")
    poses.add_argument("--tf", metavar="FRAME", help="poses are the tf transforms out of this frame (odom)")
    parser.add_argument("--corrected", metavar="TOPIC",
                        help="of nav_msgs/Path: SLAM's trajectory as it is after loop closures, which moves the keyframes")
    parser.add_argument("--mounting", type=float, nargs=7, metavar=tuple("xyz") + ("qx", "qy", "qz", "qw"),
                        help="of the lidar on what the odometry moves; without it static transforms of the bag say so")
    parser.add_argument("--rate", type=float, default=0, help="times real time; without it as fast as it goes")
    parser.add_argument("--family", default="learned", help="what describes a keyframe")
    parser.add_argument("--clouds", default="all", choices=["all", "on_request", "never"], help="which clouds to send")
    parser.add_argument("--no-intensity", action="store_true", help="leave out how strong the returns were, which exports show")
    parser.add_argument("--patience", type=float, default=30, help="give up after so many seconds without progress")
    parser.add_argument("--linger", type=float, default=0, help="stay so many seconds after the last news of the map")
    parser.add_argument("--insecure", action="store_true", help="to a server that runs with --insecure")
    parser.add_argument("bag", help=".bag (ROS 1), .db3 or its folder (ROS 2)")
    return parser.parse_args()


def mounting_of(numbers):
    if numbers is None:
        return None
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation_of(*numbers[3:]), numbers[:3]
    return T


def play(options, robot):
    """How many scans there were, and how many became keyframes."""
    pairing = Pairing(mounting_of(options.mounting))
    listener = Listener(pairing, options.points, options.odometry, options.tf)
    corrected = Corrected(robot, pairing) if options.corrected else None
    scans = keyframes = 0
    first = None
    for topic, message in messages(options.bag, listener.topics + ([options.corrected] if corrected else [])):
        if topic == options.corrected:
            corrected.path(message, listener.local_frame)
            if corrected.warning:
                pairing.lose(corrected.warning, 1)
            continue
        listener.take(topic, message)
        taken = pairing.take()
        for stamp_s, T_local_sensor, points, intensity in corrected.scans(taken) if corrected else taken:
            first = first or (stamp_s, time.monotonic())
            if options.rate > 0:
                time.sleep(max(0, first[1] + (stamp_s - first[0]) / options.rate - time.monotonic()))
            scans += 1
            try:
                keyframes += robot.add_scan(stamp_s, T_local_sensor, points, intensity)
            except headframe.BadInput as passed_over:
                pairing.lose(str(passed_over), 1)
            if sys.stderr.isatty():
                print(f"\r{scans} scans, {keyframes} keyframes", end="", file=sys.stderr)
    pairing.end()
    for why, count in pairing.lost.items():
        print(f"{count} left out: {why}")
    if corrected:
        print(f"the corrected path moved keyframes {corrected.moved} times")
    return scans, keyframes


def main():
    options = arguments()
    try:
        with headframe.Robot(options.robot, spool=options.spool, server=options.server, enrolment=options.enrol,
                             insecure=options.insecure, family=options.family, clouds=options.clouds,
                             intensity=not options.no_intensity) as robot:
            news = threading.Event()

            def told(transforms):
                print(f"revision {transforms.revision}: {len(transforms.T_component_session)} sessions on one map", flush=True)
                news.set()

            robot.on_transforms(told)
            scans, keyframes = play(options, robot)
            print(f"{scans} scans became {keyframes} keyframes")
            if scans == 0:
                raise ValueError(f"{options.bag}: no cloud has met a pose")
            robot.finish(options.patience)
            while news.wait(options.linger):
                news.clear()
    except (ValueError, headframe.Error) as fault:
        sys.exit(f"headframe_ros.replay: {fault}")


if __name__ == "__main__":
    main()
