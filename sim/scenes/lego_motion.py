#!/usr/bin/env python3
"""Writes lego-motion.csv, the motion of the device of lego.toml: python3 lego_motion.py > lego-motion.csv

The device takes "red" and "blue" from the top of the pile and puts one on the other beside it, then takes "mover" and drags
it through the pile as S4 does.
"""
import math

SAMPLE = 0.05  # s
LAYER = 0.010  # height of a brick, m
HIGH = 0.07  # height at which bricks are carried, m
SITE = (0.0, 0.16)  # place where they are put, m
DRAG_BEGINS, DRAG_ENDS = 10.0, 20.0  # s


# x, y, z (m), yaw (rad) as in lego.toml
RED = (-0.108, -0.019, 0.0254, 0.0)
BLUE = (0.108, 0.019, 0.0254, 0.0)
MOVER = (-0.22, 0.0, 0.007, 0.0)


def above(pose):
    return (pose[0], pose[1], HIGH, pose[3])


def put_down(pose, layers_below, yaw):
    """Pose of the device for a brick, gripped at `pose`, on the site on top of `layers_below` layers."""
    lowered = pose[2] - 2 * LAYER + layers_below * LAYER
    return (*SITE, lowered, yaw)


RED_DOWN = put_down(RED, 0, math.pi / 2)
BLUE_DOWN = put_down(BLUE, 1, math.pi / 2)

# time, pose (x, y, z, yaw) at that time; the device rests there
WAYPOINTS = [
    (0.0, RED), (0.5, RED),
    (1.2, above(RED)), (2.2, above(RED_DOWN)), (3.0, RED_DOWN), (3.2, RED_DOWN),
    (3.8, above(RED_DOWN)), (4.6, above(BLUE)), (5.2, BLUE), (5.4, BLUE),
    (6.0, above(BLUE)), (7.0, above(BLUE_DOWN)), (7.8, BLUE_DOWN), (8.0, BLUE_DOWN),
    (8.6, above(BLUE_DOWN)), (9.4, above(MOVER)), (9.8, MOVER), (DRAG_BEGINS, MOVER),
]

# time, brick held from then on
HOLDS = [(0.0, "-"), (0.5, "red"), (3.15, "-"), (5.35, "blue"), (7.95, "-"), (9.9, "mover")]


def eased(x):
    return x * x * (3 - 2 * x)


def between_waypoints(t):
    for (t_0, from_pose), (t_1, to_pose) in zip(WAYPOINTS, WAYPOINTS[1:]):
        if t <= t_1:
            s = eased((t - t_0) / (t_1 - t_0))
            return tuple((1 - s) * a + s * b for a, b in zip(from_pose, to_pose))
    return WAYPOINTS[-1][1]


def dragged(u):
    """Target of S4, with a clock that starts smoothly within 1 s."""
    t = u * u / 2 if u < 1 else u - 0.5
    angle = 2 * math.pi * t
    return (-0.22 * math.cos(0.2 * angle), 0.035 * math.sin(0.37 * angle),
            0.007 + 0.004 * (1 - math.cos(0.3 * angle)), 0.6 * math.sin(0.25 * angle))


def pose(t):
    return between_waypoints(t) if t <= DRAG_BEGINS else dragged(t - DRAG_BEGINS)


def held(t):
    return [body for since, body in HOLDS if since <= t + 1e-9][-1]


def main():
    print("t,pen.x,pen.y,pen.z,pen.qw,pen.qx,pen.qy,pen.qz,hold")
    for n in range(round(DRAG_ENDS / SAMPLE) + 1):
        t = n * SAMPLE
        x, y, z, yaw = pose(t)
        print(f"{t:.2f},{x:.7f},{y:.7f},{z:.7f},{math.cos(yaw / 2):.9f},0,0,{math.sin(yaw / 2):.9f},{held(t)}")


if __name__ == "__main__":
    main()
