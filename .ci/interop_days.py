"""Opens the files of a trial's days with other people's readers and holds them against growth.csv."""

import csv
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pygltflib
import trimesh
import xmlschema
from plantbox.rsml.rsml_data import RsmlData

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

# CPlantBox takes lengths in cm, times in days, and the creation times of nodes for the growth of a root system.
for plant, days in seen.items():
    for path in sorted((results / "days").glob(f"{plant}-*.rsml")):
        data = RsmlData()
        data.open_rsml(str(path))
        index = int(ElementTree.parse(path).findtext("metadata/time-sequence/index"))
        lengths = series[plant][index]
        lines = [10.0 * np.array(line) for line in data.polylines]
        told = sorted(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)
        assert np.allclose(told, sorted(lengths.values()), atol=0.01), path
        parents = data.properties["parent-poly"]
        assert [p < 0 for p in parents] == [n < 0 for n in data.properties["parent-node"]], path
        for line, parent, node in zip(lines, parents, data.properties["parent-node"]):
            away = np.linalg.norm(lines[parent] - line[0], axis=1)
            assert parent < 0 or away[int(node)] <= away.min() + 1e-3, path
        assert data.tagnames[:2] == ["diameter", "node_creation_time"] and 0.01 < np.median(data.radii) < 0.5, path
        dates = [0.0, *sorted(days)]
        assert set(np.round(data.cts, 6)) <= set(dates[: index + 1]) and data.max_ct == dates[index], path
        # What was there on a day is as long as that day's own roots.
        flat = np.split(np.array(data.cts), np.cumsum([len(line) for line in lines])[:-1])
        for date, known in zip(dates[:index], (series[plant][n] for n in range(index))):
            there = sum(np.linalg.norm(np.diff(line, axis=0), axis=1)[(t <= date)[1:]].sum() for line, t in zip(lines, flat))
            assert abs(there / sum(known.values()) - 1) < 0.25, (path, date, there, sum(known.values()))
print("RSML over days: CPlantBox reads lengths, parents, diameters and creation times")

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
