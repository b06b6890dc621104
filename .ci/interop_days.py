"""Opens the files of a trial's days with other people's readers and holds them against growth.csv."""

import csv
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pygltflib
import trimesh
import xmlschema

results, schema = map(pathlib.Path, sys.argv[1:3])

# Per plant the numbers of the roots that growth.csv has on its last day.
seen = {}
for row in csv.DictReader(open(results / "growth.csv", newline="")):
    if row["state"] != "vanished":
        seen.setdefault(row["plant"], {}).setdefault(float(row["to_day"]), {})[int(row["root_id"])] = float(row["length_to_mm"])
assert len(seen) == 4, sorted(seen)

validator = xmlschema.XMLSchema(schema)
series = {}
for path in sorted((results / "days").glob("*.rsml")):
    validator.validate(path)
    tree = ElementTree.parse(path).getroot()
    sequence = tree.find("metadata/time-sequence")
    assert sequence.findtext("unified") == "true"
    plant, _ = path.stem.split("-", 1)
    lengths = {}
    for root in tree.iter("root"):
        line = np.array([[float(p.get(c)) for c in "xyz"] for p in root.iterfind("geometry/polyline/point")])
        lengths[int(root.get("id").rsplit("-", 1)[-1])] = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    series.setdefault(plant, {})[int(sequence.findtext("index"))] = lengths
for plant, days in seen.items():
    assert sorted(series[plant]) == list(range(len(days) + 1)), plant
    last = series[plant][len(days)]
    told = days[max(days)]
    assert last.keys() == told.keys() and all(abs(last[i] - told[i]) < 0.02 for i in told), plant
    assert last.keys() & series[plant][0].keys(), "no root is on both days"
print(f"RSML over days: valid, {len(series)} plants, {sum(len(d) for d in series.values())} days")

for plant, days in series.items():
    path = results / "days" / f"{plant}.glb"
    scene, gltf = trimesh.load(path), pygltflib.GLTF2().load(str(path))
    top = [gltf.nodes[n] for n in gltf.scenes[gltf.scene].nodes]
    assert [node.name for node in top] == [f"day-{n + 1}" for n in sorted(days)]
    for n, node in enumerate(top):
        assert {gltf.nodes[c].extras["root_id"] for c in node.children} == set(days[n]), (plant, n)
    assert len(scene.geometry) == sum(map(len, days.values()))
    [animation] = gltf.animations
    assert [c.target.path for c in animation.channels] == ["scale"] * len(top)
    assert [c.target.node for c in animation.channels] == gltf.scenes[gltf.scene].nodes
    assert {s.interpolation for s in animation.samplers} == {"STEP"}
print(f"glTF over days: {len(series)} plants, a node per day, one animation")
