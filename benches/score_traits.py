#!/usr/bin/env python3
"""Roots, diameters and orders of results against the truth, one row of a table per result.

usage: score_traits.py RESULT=TRUTH ... [--z-min MM] [--z-max MM]

RESULT  a results folder with roots.csv, or such a table
TRUTH   a folder with roots.json and tank.json, as `rootvox simulate` writes them
Both sides are cut to points every 0.25 mm inside z-min < z < z-max, rho < r - tau - 1 mm (z-min: 16 mm under the
water; z-max: 2 mm above the lowest belt where one starts above the floor, else 178 mm). Simulated roots run along that very
bound, 1 mm before the wall: a found point that is right lies inside or outside with the true point that it is nearest to.

F1, rms      points within 1 mm; rms of the found points within 2 mm of the truth
length       found over true length in the region, less 1
tips P R     last points of the roots, matched one to one within 2 mm, nearest pairs first; a pair lies where its true one lies
branch P R   first points of laterals, likewise
d err        median |found - true diameter| of found points within 1 mm of a true root of at least 0.6 mm
d bias       median found - true diameter of the same points
volume       sum of pi d^2 / 4 ds found over true in the region, less 1
order        share of the found length within 1 mm of the truth that has the nearest true point's order
Needs numpy and scipy.
"""

import argparse
import csv
import json
import pathlib

import numpy as np
from scipy.spatial import cKDTree

STEP = 0.25


def resample(points, values):
    s = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    at = np.arange(0.0, s[-1], STEP) if s[-1] >= STEP else s[:1]
    columns = [np.interp(at, s, points[:, k]) for k in range(3)] + [np.interp(at, s, values)]
    return np.stack(columns, axis=1)


class Roots:
    """Polylines with diameters, as points: xyz, diameter, order; and their ends."""

    def __init__(self, roots):
        rows = [np.c_[resample(p, d), np.full(len(resample(p, d)), order)] for p, d, order, _ in roots]
        self.points = np.vstack(rows) if rows else np.zeros((0, 5))
        self.tips = np.array([p[-1] for p, *_ in roots]).reshape(-1, 3)
        self.bases = np.array([p[0] for p, _, _, parent in roots if parent >= 0]).reshape(-1, 3)
        self.count = len(roots)


def truth(folder):
    return Roots(
        [
            (np.array(r["points"]), 2 * np.array(r["radii"]), r["order"], r["parent"])
            for r in json.load(open(folder / "roots.json"))
        ]
    )


def found(path):
    rows = list(csv.DictReader(open(path / "roots.csv" if path.is_dir() else path, newline="")))
    by_id = {}
    for row in rows:
        by_id.setdefault(row["root_id"], []).append(row)
    return Roots(
        [
            (
                np.array([[float(r[c]) for c in ("x_mm", "y_mm", "z_mm")] for r in rs]),
                np.array([float(r["diameter_mm"]) for r in rs]),
                int(rs[0]["order"]),
                int(rs[0]["parent_id"]),
            )
            for rs in by_id.values()
        ]
    )


def matched(a, b, limit=2.0):
    if not len(a) or not len(b):
        return []
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    pairs, rows, columns = [], set(), set()
    for flat in np.argsort(distance, axis=None):
        i, j = divmod(int(flat), len(b))
        if distance[i, j] > limit:
            break
        if i not in rows and j not in columns:
            rows.add(i), columns.add(j)
            pairs.append((i, j))
    return pairs


def score(result, folder, z_min, z_max):
    tank = json.load(open(folder / "tank.json"))
    z_min = tank["z_w"] + 16.0 if z_min is None else z_min
    rho = tank["r"] - tank["tau"] - 1.0
    inside = lambda p: (p[:, 2] > z_min) & (p[:, 2] < z_max) & (np.hypot(p[:, 0], p[:, 1]) < rho)
    real, have = truth(folder), found(result)
    t = real.points[inside(real.points)]
    distance, near = cKDTree(real.points[:, :3]).query(have.points[:, :3])
    counts = np.where(distance <= 1.0, inside(real.points)[near], inside(have.points))
    f, distance, near = have.points[counts], distance[counts], near[counts]
    recall = (cKDTree(have.points[:, :3]).query(t[:, :3])[0] <= 1.0).mean()
    right = distance <= 1.0
    precision = right.mean()
    thick = right & (real.points[near, 3] >= 0.6)
    off = (f[:, 3] - real.points[near, 3])[thick]
    row = {
        "roots": have.count,
        "P": precision,
        "R": recall,
        "F1": 2 * precision * recall / (precision + recall),
        "rms": np.sqrt((distance[distance <= 2.0] ** 2).mean()),
        "length": len(f) / len(t) - 1,
    }
    for name in ("tips", "bases"):
        a, b = (getattr(side, name) for side in (have, real))
        pairs = matched(a, b)
        n = sum(inside(b)[j] for _, j in pairs)
        alone = inside(a).copy()
        alone[[i for i, _ in pairs]] = False
        label = {"tips": "tip", "bases": "branch"}[name]
        row[label + " P"], row[label + " R"] = n / max(n + alone.sum(), 1), n / max(inside(b).sum(), 1)
    row["d err"] = np.median(np.abs(off))
    row["d bias"] = np.median(off)
    row["volume"] = (f[:, 3] ** 2).sum() / (t[:, 3] ** 2).sum() - 1
    row["order"] = (f[right, 4] == real.points[near[right], 4]).mean()
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", metavar="RESULT=TRUTH")
    parser.add_argument("--z-min", type=float)
    parser.add_argument("--z-max", type=float, default=178.0)
    args = parser.parse_args()
    for n, pair in enumerate(args.pairs):
        result, folder = map(pathlib.Path, pair.split("=", 1))
        row = score(result, folder, args.z_min, args.z_max)
        if n == 0:
            print("| result | " + " | ".join(row) + " |")
            print("|---" * (len(row) + 1) + "|")
        cells = [f"{v:+.3f}" if k in ("length", "volume", "d bias") else f"{v:.3f}" if k != "roots" else str(v) for k, v in row.items()]
        print(f"| {result.name} | " + " | ".join(cells) + " |")


main()
