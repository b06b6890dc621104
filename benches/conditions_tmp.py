"""The same defaults under many conditions: runs pipelines/conditions.toml and prints its scores as a table.

    cargo build --release
    python3 benches/conditions.py [options of rootvox run, such as --cache DIR]
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parents[1]

with tempfile.TemporaryDirectory() as folder:
    study = HERE / "pipelines/conditions.toml"
    command = ["/tmp/ex/rv25", "run", study, "--results", folder, *sys.argv[1:]]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    print("| capture | precision | recall | F1 | rms mm |\n|---|---|---|---|---|")
    for path in sorted(Path(folder).glob("*/score.json")):
        score = json.loads(path.read_text())
        at = next(a for a in score["at"] if a["tolerance_mm"] == 1.0)
        print(f"| {path.parent.name} | {at['precision']:.3f} | {at['recall']:.3f} | {at['f1']:.3f} | {score['rms_mm']:.3f} |")
