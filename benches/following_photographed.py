"""How well roots are followed through photographs: the days of a trial against the truth of each.

    rootvox simulate pipelines/days.toml --out captures/days
    rootvox run user.toml                               # photographs and tank.json alone, see docs/trials.md
    python3 benches/following_photographed.py captures/days results/user/trial PLANT

Of the roots that truly are there on two days in a row, 2 mm of each in clear sight on both: the share with one number on both; the median
error of the elongation where it is 1 mm or more; told births of roots that were there before, and told deaths of roots that are still there, both as
shares of these roots. Needs numpy."""

import csv
import json
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np

NEAR_MM, STEP_MM, LEAST_MM, TOLD_MM = 1.5, 0.5, 2.0, 1.0


def views(path):
    file = json.loads(path.read_text())
    for view in file["views"]:
        k = {**file.get("intrinsics", {}), **view.get("intrinsics", {})}
        yield pathlib.Path(view["file"]).name, k, np.array(view["R"], float).reshape(3, 3), np.array(view["t"], float)


def bent(k, x):
    """The lens: from ideal to distorted coordinates."""
    k1, k2, p1, p2, k3 = (k.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3"))
    r2 = (x * x).sum(1)
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    xy = x[:, 0] * x[:, 1]
    return x * radial[:, None] + np.stack([2 * p1 * xy + p2 * (r2 + 2 * x[:, 0] ** 2), p1 * (r2 + 2 * x[:, 1] ** 2) + 2 * p2 * xy], 1)


def truth_from_found(found, truth, tank):
    """The rigid motion from the frame of found cameras into that of the true ones, by what pixels show of the printed belts."""
    r, pairs = tank["r"] + 0.1, []
    depths = [z for a, b in tank["belts"] for z in np.linspace(a + 3, b - 3, 3)]
    known = {name: rest for name, *rest in views(found)}
    azimuths = np.radians(np.arange(0, 360, 5))
    print_ = np.array([[r * np.cos(a), r * np.sin(a), z] for z in depths for a in azimuths])
    for name, k, R, t in views(truth):
        kf, Rf, tf = known[name]
        to, centre = -R.T @ t, -Rf.T @ tf
        facing = ((to - print_) / np.linalg.norm(to - print_, axis=1)[:, None] * print_ / r)[:, :2].sum(1)
        seen = print_[facing > 0.6]
        cam = seen @ R.T + t
        pixel = bent(k, cam[:, :2] / cam[:, 2:]) * k["f"] + [k["cx"], k["cy"]]
        goal = (pixel - [kf["cx"], kf["cy"]]) / kf["f"]
        ideal = goal.copy()
        for _ in range(20):
            ideal += goal - bent(kf, ideal)
        d = np.column_stack([ideal, np.ones(len(ideal))]) @ Rf
        a, b, c = (d[:, :2] ** 2).sum(1), d[:, :2] @ centre[:2], centre[:2] @ centre[:2] - r * r
        root = b * b - a * c
        hit = root > 0
        pairs.append(np.hstack([centre + d[hit] * ((-b - np.sqrt(np.where(hit, root, 0)))[hit] / a[hit])[:, None], seen[hit]]))
    pairs = np.vstack(pairs)
    f, t = pairs[:, :3], pairs[:, 3:]
    u, _, vt = np.linalg.svd((t - t.mean(0)).T @ (f - f.mean(0)))
    R = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return R, t.mean(0) - R @ f.mean(0)


def fine(points):
    points = np.asarray(points, float)
    steps = np.maximum(1, np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / STEP_MM)).astype(int)
    parts = [a + (b - a) * np.arange(n)[:, None] / n for a, b, n in zip(points, points[1:], steps)]
    return np.vstack([*parts, points[-1:]])


def length(points):
    return np.linalg.norm(np.diff(np.asarray(points, float), axis=0), axis=1).sum()


def covered(roots, by):
    """Of each root the number of that in `by` which most of it, and half at least, lies on."""
    names, places = list(by), [fine(p) for p in by.values()]
    result = {}
    for name, points in roots.items():
        own = fine(points)
        far = np.array([np.min(np.linalg.norm(own[:, None] - p[None], axis=2), axis=1) for p in places])
        near = [int(((far.argmin(0) == n) & (far[n] < NEAR_MM)).sum()) for n in range(len(names))]
        best = int(np.argmax(near)) if near else 0
        if near and 2 * near[best] >= len(own) and near[best]:
            result[name] = names[best]
    return result


def main(captures, trial, plant):
    tank = json.loads(next(captures.glob(f"{plant}-*/tank.json")).read_text())
    clear = [tank["belts"][0][1], tank["belts"][-1][0]]
    growth = [r for r in csv.DictReader(open(trial / "growth.csv", newline="")) if r["plant"] == plant]
    files = {}
    for path in (trial / "days").glob(f"{plant}-*.rsml"):
        tree = ElementTree.parse(path).getroot()
        number = lambda root: int(re.sub(r"\D", "", root.get("id")))
        line = lambda root: [[float(p.get(c)) for c in "xyz"] for p in root.iterfind("geometry/polyline/point")]
        files[int(tree.findtext("metadata/time-sequence/index"))] = (path.stem, {number(r): line(r) for r in tree.iter("root")})
    names = [files[n][0] for n in sorted(files)]
    R, t = truth_from_found(trial.parent / names[0] / "cameras.json", captures / names[0] / "cameras.json", tank)
    traced = [{i: np.asarray(p) @ R.T + t for i, p in files[n][1].items()} for n in sorted(files)]
    truth = [{r["id"]: r["points"] for r in json.loads((captures / name / "roots.json").read_text())} for name in names]
    seen = [{i: p for i, p in day.items() if length([q for q in p if clear[0] < q[2] < clear[1]] or [p[0]]) >= LEAST_MM} for day in truth]
    of_true = [covered(t, f) for t, f in zip(seen, traced)]
    true_of = [covered(f, t) for t, f in zip(truth, traced)]
    dates = sorted({float(r["from_day"]) for r in growth} | {float(r["to_day"]) for r in growth})
    both = kept = births = deaths = ghosts = 0
    errors, lost = [], []
    for day in range(1, len(names)):
        # What was seen before an interval's first day counts from there, so elongation is judged between days in a row.
        told = [r for r in growth if float(r["to_day"]) == dates[day] and float(r["from_day"]) == dates[day - 1]]
        for i in seen[day - 1].keys() & seen[day].keys():
            both += 1
            was, now = of_true[day - 1].get(i), of_true[day].get(i)
            if was is None or was != now:
                lost.append(f"root {i} between {names[day - 1]} and {names[day]}: {was} -> {now}, {length(truth[day - 1][i]):.1f} mm")
                continue
            kept += 1
            grown = length(truth[day][i]) - length(truth[day - 1][i])
            rows = [r for r in told if int(r["root_id"]) == was and r["elongation_mm"]]
            if grown >= TOLD_MM and rows:
                errors.append(float(rows[0]["elongation_mm"]) - grown)
                errors[-1] = (errors[-1], errors[-1] / grown)
        for row in (r for r in growth if float(r["to_day"]) == dates[day]):
            i = int(row["root_id"])
            if row["state"] == "appeared":
                true = true_of[day].get(i)
                births += true in seen[day - 1]
                ghosts += true is None
            elif row["state"] == "vanished":
                true = true_of[day - 1].get(i)
                deaths += true in seen[day]
    print("roots", [len(t) for t in truth], "traced", [len(t) for t in traced])
    print("\n".join(lost))
    mm, share = np.array(errors).T
    print(f"keep their identity  {100 * kept / both:.1f} % of {both}")
    print(f"elongation           median error {100 * np.median(np.abs(share)):.1f} % of {len(share)}; mean {mm.mean():+.2f}, median |{np.median(np.abs(mm)):.2f}| mm")
    print(f"false births         {100 * births / both:.1f} %; of no true root {ghosts}")
    print(f"false deaths         {100 * deaths / both:.1f} %")


main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3])
