"""What each step from photographs to voxels is worth, on the four photographed data sets, as a table.

    git worktree add /tmp/steps && cd /tmp/steps
    git apply benches/steps.patch && cargo build --release     # the program with earlier steps in place of the share of root
    python3 benches/steps.py DATA

DATA holds the folders licorice-sim, fibrous-dim, dense-dev and wild-dev. The patch lets STEP say what a pixel tells: `difference` from
the background, whatever the colour; `matting`, the share of root, every pixel with the same say; `gate`, the share, with no say for
pixels that are told by less than a half and the same for all others."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

# Depth of the grid, belts and scored depths, mm.
SETS = {
    "licorice-sim": (180, [[0.0, 28.0], [214.6, 246.6]], 30, 178),
    "fibrous-dim": (154, [[0.0, 24.0], [154.0, 180.0]], 26, 150),
    "dense-dev": (190, [[0.0, 26.0], [192.0, 220.0]], 30, 178),
    "wild-dev": (180, [[0.0, 26.0], [182.0, 210.0]], 30, 178),
}
STEPS = {
    "background of the surroundings, 1 mm": (None, ["grid.spacing=1.0", "contrast.background=window"]),
    "background from the turn: difference": ("difference", ["grid.spacing=1.0"]),
    "matting": ("matting", ["grid.spacing=1.0"]),
    "confidence": ("gate", ["grid.spacing=1.0"]),
    "weighted merge": (None, ["grid.spacing=1.0"]),
    "scale from the photographs": (None, []),
    "a fifth of the lowest views (the defaults)": (None, ["merge.quantile=0.2"]),
}
HERE = pathlib.Path(__file__).parents[1]


def scores(data, name, step, options, work):
    """F1 at 1 mm of root voxels and traced roots, and the error of the traced length."""
    depth, belts, z_min, z_max = SETS[name]
    study = work / "study.toml"
    study.write_text(
        f'[study]\nname = "steps"\n[photos]\ndir = "{data / name}"\n[cameras]\nsource = "file"\n[tank]\nfile = "tank.json"\n'
        f'belts = {belts}\n[grid]\ndepth = {depth}\n[truth]\nroots = "roots.json"\nz_min = {z_min}\nz_max = {z_max}\n'
    )
    # The patch is in no key: every step has a store of its own.
    with tempfile.TemporaryDirectory() as cache:
        command = [HERE / "target/release/rootvox", "run", study, "--cache", cache, "--results", work]
        command += [word for option in ["merge.quantile=0.25", *options] for word in ("--set", option)]
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, **({"STEP": step} if step else {})})
    voxels, roots = (json.loads((work / "steps" / file).read_text()) for file in ("score.json", "roots_score.json"))
    f1 = lambda score: next(at["f1"] for at in score["at"] if at["tolerance_mm"] == 1.0)
    return f1(voxels), f1(roots["score"]), 100 * roots["score"]["length_bias"]


def main(data):
    print("| step | " + " | ".join(f"{name} voxels | traced | length" for name in SETS) + " |")
    print("|---|" + "---|---|---|" * len(SETS))
    for label, (step, options) in STEPS.items():
        row = []
        for name in SETS:
            with tempfile.TemporaryDirectory() as folder:
                row.append("{:.3f} | {:.3f} | {:+.1f} %".format(*scores(data, name, step, options, pathlib.Path(folder))))
        print(f"| {label} | " + " | ".join(row) + " |", flush=True)


main(pathlib.Path(sys.argv[1]).resolve())
