"""Pixels of random directions through every lens model, by OpenCV: the figures that tests/lenses.rs holds ours against.

    pip install opencv-python-headless
    python3 tests/data/lenses/points.py 40 > tests/data/lenses/opencv.json
    python3 tests/data/lenses/points.py 100000 > /tmp/lenses.json
    ROOTVOX_LENSES=/tmp/lenses.json cargo test --release --test lenses

Prints JSON: per lens its `cameras.json` intrinsics and points [x, y, u, v], (x, y, 1) the direction, (u, v) the pixel.
"""

import json
import sys

import cv2
import numpy as np

WIDTH, HEIGHT, CX, CY = 968, 648, 488.2, 320.1
# Name, focal lengths, skew, greatest |x| and |y|, OpenCV's coefficients in its order.
BROWN = [
    ("pinhole", 984.0, 984.0, 0.6, []),
    ("pixels not square", 1003.68, 984.0, 0.6, []),
    ("four coefficients", 984.0, 984.0, 0.6, [-0.09, 0.05, 4e-4, -3e-4]),
    ("five coefficients", 1003.68, 984.0, 0.6, [-0.28, 0.11, 4e-4, -3e-4, -0.02]),
    ("rational", 700.0, 705.0, 0.8, [0.31, -0.05, 4e-4, -3e-4, 0.01, 0.62, 0.03, -0.004]),
    ("thin prism", 984.0, 980.0, 0.6, [-0.09, 0.05, 4e-4, -3e-4, 0.01, 0.02, -0.03, 0.004, 1e-3, -2e-4, 5e-4, 3e-4]),
]
FISHEYE = [
    ("fisheye", 500.0, 500.0, 0.0, 2.0, [0.03, -0.01, 4e-3, -1e-3]),
    ("fisheye with skew", 510.0, 500.0, 1.5, 1.2, [-0.04, 0.02, -3e-3, 2e-4]),
]
ORDER = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"]


def lens(fx, fy, skew, values):
    extra = {"b1": fx - fy, "b2": skew}
    extra = {key: value for key, value in extra.items() if value}
    return {"width": WIDTH, "height": HEIGHT, "f": fy, "cx": CX, "cy": CY, **values, **extra}


def main(count):
    rng = np.random.default_rng(7)
    zero = np.zeros(3)
    out = []
    for name, fx, fy, reach, d in BROWN:
        xy = rng.uniform(-reach, reach, (count, 2))
        k = np.array([[fx, 0, CX], [0, fy, CY], [0, 0, 1]])
        uv, _ = cv2.projectPoints(np.c_[xy, np.ones(count)], zero, zero, k, np.array(d) if d else None)
        values = dict.fromkeys(ORDER[:5], 0.0) | dict(zip(ORDER, d))
        out.append({"name": name, "lens": lens(fx, fy, 0.0, values), "points": np.c_[xy, uv.reshape(-1, 2)].tolist()})
    for name, fx, fy, skew, reach, d in FISHEYE:
        xy = rng.uniform(-reach, reach, (count, 2))
        k = np.array([[fx, 0, CX], [0, fy, CY], [0, 0, 1]])
        points = np.c_[xy, np.ones(count)].reshape(-1, 1, 3)
        uv, _ = cv2.fisheye.projectPoints(points, zero, zero, k, np.array(d), alpha=skew / fx)
        values = {"model": "fisheye", **dict(zip(["k1", "k2", "k3", "k4"], d))}
        out.append({"name": name, "lens": lens(fx, fy, skew, values), "points": np.c_[xy, uv.reshape(-1, 2)].tolist()})
    json.dump({"opencv": cv2.__version__, "lenses": out}, sys.stdout)


main(int(sys.argv[1]))
