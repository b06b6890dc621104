#!/usr/bin/env python3
"""Cameras and tank from the photographs alone, on captures whose true cameras are known.

    python3 benches/calibration.py --rootvox target/release/rootvox --work FOLDER [--data FOLDER ...] [NAME ...]

Photographs the captures below (other tanks, lenses, heights, numbers of views), runs structure from motion and
registration on photographs and tank alone, and prints a table (Markdown): errors against the true cameras, each with
the estimated standard deviation in brackets. Folders given by --data (images/, tank.json, cameras.json) join the
table. What is finished stays in FOLDER and is not computed again.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys

# Each: [tank], [simulate.capture]. Table offsets, jitter and lens differ on purpose; belts are as wide as on a real tank.
CAPTURES = {
    "jar-12": (
        dict(radius=45.0, height=150.0, wall=3.0, water_level=10.0, belts=[[0.0, 22.0], [126.0, 150.0]], index=dict(wall=1.52)),
        dict(views=12, turn_jitter_deg=4.0, focal_35mm=50.0, roll_deg=-1.0, table_offset_mm=1.0),
    ),
    "above-24": (
        dict(radius=60.0, height=180.0, wall=4.0, water_level=14.0, belts=[[0.0, 24.0], [154.0, 180.0]]),
        dict(views=24, turn_jitter_deg=3.0, focal_35mm=35.0, height_mm=-120.0, distortion=dict(k1=-0.12, k2=0.06, p1=0.0, p2=0.0, k3=0.0)),
    ),
    "below-18": (
        dict(radius=70.0, height=220.0, wall=5.0, water_level=12.0, belts=[[0.0, 26.0], [190.0, 220.0]]),
        dict(views=18, turn_jitter_deg=4.0, focal_35mm=40.0, height_mm=270.0, table_radii=0.0, distortion=dict(k1=0.05, k2=-0.02, p1=2e-4, p2=2e-4, k3=0.0)),
    ),
    "tilted-20": (
        dict(radius=60.0, height=180.0, wall=4.0, water_level=14.0, belts=[[0.0, 24.0], [154.0, 180.0]]),
        dict(views=20, turn_jitter_deg=4.0, focal_35mm=28.0, roll_deg=7.0, pan_deg=4.0, tilt_deg=4.0, table_offset_mm=4.0,
             distance_mm=390.0, distortion=dict(k1=-0.15, k2=0.05, p1=-4e-4, p2=3e-4, k3=0.0)),
    ),
    "wide-16": (
        dict(radius=110.0, height=190.0, wall=6.0, water_level=12.0, belts=[[0.0, 25.0], [160.0, 190.0]]),
        dict(views=16, turn_jitter_deg=4.0, focal_35mm=45.0, table_offset_mm=5.0, principal_offset=[-0.01, 0.008]),
    ),
    "dark-24": (
        dict(radius=50.0, height=200.0, wall=3.0, water_level=12.0, belts=[[0.0, 24.0], [174.0, 200.0]]),
        dict(views=24, turn_jitter_deg=2.0, focal_35mm=60.0, background_rgb=[0.08, 0.08, 0.09], noise_sigma=5.0,
             exposure_drift=0.04, blur_px=0.7, jpeg_quality=85),
    ),
    "dense-72": (
        dict(radius=60.0, height=180.0, wall=4.0, water_level=14.0, belts=[[0.0, 24.0], [154.0, 180.0]]),
        dict(views=72, turn_jitter_deg=4.0, focal_35mm=36.0),
    ),
}

# A small plant: the cameras are what counts here.
GROWTH = dict(first_order=dict(count=8), second_order=dict(count=6))

# The volume only has to exist: a coarse grid and thresholds that no root reaches keep it cheap.
COARSE = """
[grid]
spacing = 4.0
[extract]
low = 1e6
high = 1e6
[rootness]
sigma = [4.0]
[contrast]
enabled = false
[diameters]
enabled = false
"""


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    return json.dumps(value)


def section(name, values):
    return f"[{name}]\n" + "".join(f"{k} = {toml(v)}\n" for k, v in values.items())


def call(*words):
    done = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout


def measure(args, name, folder):
    """Runs a capture's folder and returns its numbers."""
    work = args.work
    study = work / f"{name}.toml"
    text = section("study", dict(name=name)) + section("photos", dict(dir=str(folder.resolve())))
    text += section("cameras", dict(source="sfm")) + section("tank", dict(file="tank.json")) + COARSE + args.extra
    study.write_text(text)
    call(args.rootvox, "run", study, "--cache", work / "cache", "--results", work / "results")
    result = work / "results" / name
    errors = json.loads(call(args.rootvox, "evaluate", result, folder, "--json", "--free-azimuth"))["cameras"]
    return errors, json.loads((result / "calibration" / "calibration.json").read_text())


COLUMNS = [
    # heading, error, standard deviation, digits
    ("f, %", lambda e, u, f: 100 * e["focal"], lambda u, f: 100 * u["focal_px"] / f, 3),
    ("cx, px", lambda e, u, f: e["principal_point_px"][0], lambda u, f: u["principal_point_px"][0], 2),
    ("cy, px", lambda e, u, f: e["principal_point_px"][1], lambda u, f: u["principal_point_px"][1], 2),
    ("k1", lambda e, u, f: e["distortion"][0], lambda u, f: u["distortion"][0], 4),
    ("k2", lambda e, u, f: e["distortion"][1], lambda u, f: u["distortion"][1], 4),
    ("scale, %", lambda e, u, f: 100 * e["scale"], lambda u, f: 100 * u["scale"], 4),
    ("axis tilt, °", lambda e, u, f: e["axis_tilt_deg"], lambda u, f: u["axis_tilt_deg"], 4),
    ("axis offset, mm", lambda e, u, f: e["axis_offset_mm"], lambda u, f: u["axis_offset_mm"], 3),
    ("height, mm", lambda e, u, f: e["height_mm"], lambda u, f: u["height_mm"], 3),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rootvox", required=True, type=pathlib.Path)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--data", action="append", default=[], type=pathlib.Path)
    parser.add_argument("--extra", default="", help="more of the study file, such as a [pose] section")
    parser.add_argument("names", nargs="*", metavar="NAME", help="captures to photograph; all when none is named")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    folders = [(folder.name, folder) for folder in args.data]
    for name in args.names or CAPTURES:
        tank, capture = CAPTURES[name]
        folder = args.work / "captures" / name
        if not folder.exists():
            study = args.work / f"{name}-simulate.toml"
            study.write_text(
                section("tank", tank) + section("simulate", dict(seed=1 + list(CAPTURES).index(name)))
                + section("simulate.growth", GROWTH) + section("simulate.capture", capture)
            )
            call(args.rootvox, "simulate", study, "--out", folder, "--cache", args.work / "cache")
        folders.append((name, folder))
    heads = ["capture", "views", "SfM, px", "water, px"] + [c[0] for c in COLUMNS]
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads), flush=True)
    ratios = []
    for name, folder in folders:
        e, calibration = measure(args, name, folder)
        q = calibration["quality"]
        # Silhouettes alone tell no standard deviations.
        u, f = (q["adjustment"] or {}).get("uncertainty"), calibration["lens"]["f"]
        cells = [name, str(e["views"]), f"{q['sfm_rms_px']:.2f}", f"{e['water_rms_px']:.3f}"]
        for _, error, sigma, digits in COLUMNS:
            x, s = error(e, u, f), sigma(u, f) if u else None
            cells.append(f"{x:.{digits}f} ({s:.{digits}f})" if u else f"{x:.{digits}f}")
            ratios.extend([abs(x) / s if s else math.inf] if u else [])
        print("| " + " | ".join(cells) + " |", flush=True)
    if not ratios:
        return
    ratios.sort()
    share = [sum(r <= k for r in ratios) / len(ratios) for k in (1, 2, 3)]
    print(f"\nerrors within 1, 2 and 3 standard deviations: {', '.join(f'{100 * s:.0f} %' for s in share)}; "
          f"the largest is {ratios[-1]:.1f}")


if __name__ == "__main__":
    main()
