"""Rootness at one scale: rootvox's stage against ITK's recursive Hessian with vesselness and scikit-image's sato, on a
volume of the same shape, in one run.

    cargo build --release
    pip install numpy scikit-image itk
    python3 benches/rootness.py pipelines/licorice.toml --set photos.dir=PATH
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import itk
import numpy as np
from skimage.filters import sato

ROOTVOX = Path(__file__).parents[1] / "target/release/rootvox"
SIGMA = 1.0


def stages(arguments):
    """Seconds of the run's merge, rootness, suppress and extract, and the shape of its volume."""
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder, "trace.json")
        command = [ROOTVOX, "run", *arguments, "--cache", Path(folder, "cache"), "--results", folder, "--trace", trace]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        events = json.loads(trace.read_text())
        events = events if isinstance(events, list) else events["traceEvents"]
        seconds = {e["name"].split("/")[0]: e["dur"] / 1e6 for e in events if e.get("ph") == "X"}
        zarr = next(Path(folder, "cache").glob("**/coverage/zarr.json"))
        return seconds, json.loads(zarr.read_text())["shape"]


def timed(what):
    start = time.perf_counter()
    what()
    return time.perf_counter() - start


def vesselness(volume):
    hessian = itk.hessian_recursive_gaussian_image_filter(itk.image_from_array(volume), sigma=SIGMA)
    measure = itk.Hessian3DToVesselnessMeasureImageFilter[itk.F].New(hessian)
    measure.Update()


seconds, shape = stages(sys.argv[1:])
volume = np.random.default_rng(1).random(shape, np.float32)
rows = [
    (f"rootvox {stage}", seconds[stage]) for stage in ("merge", "rootness", "suppress", "extract", "trace", "traits")
]
rows.append(("ITK Hessian + vesselness", timed(lambda: vesselness(volume))))
rows.append(("scikit-image sato", timed(lambda: sato(volume, sigmas=[SIGMA], black_ridges=False, mode="reflect"))))
print(f"{' x '.join(map(str, shape))} voxels, sigma {SIGMA} voxels")
for name, value in rows:
    print(f"{name:26} {value:7.2f} s   {value / seconds['rootness']:6.1f} x rootness")
