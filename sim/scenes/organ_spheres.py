#!/usr/bin/env python3
"""Writes organ-spheres.csv, the centres of the spheres of organ.toml: python3 organ_spheres.py > organ-spheres.csv

They are spread evenly over an ellipsoid by the golden angle.
"""
import math

COUNT = 120
HALF_AXES = (0.045, 0.055, 0.035)  # m


def main():
    print("x,y,z")
    for i in range(COUNT):
        z = 1 - (2 * i + 1) / COUNT
        r = math.sqrt(1 - z * z)
        angle = i * math.pi * (3 - math.sqrt(5))
        unit = (r * math.cos(angle), r * math.sin(angle), z)
        print(",".join(f"{a * x:.6f}" for a, x in zip(HALF_AXES, unit)))


if __name__ == "__main__":
    main()
