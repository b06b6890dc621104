"""Opens the files of a result's roots with other people's readers and holds them against roots.csv."""

import csv
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import morphio
import numpy as np
import pygltflib
import trimesh
import xmlschema
import zarr

results, schema = map(pathlib.Path, sys.argv[1:3])

roots = {}
for row in csv.DictReader(open(results / "roots.csv", newline="")):
    roots.setdefault(int(row["root_id"]), []).append(row)
assert roots, "no root was traced"
points = {i: np.array([[float(r[c]) for c in ("x_mm", "y_mm", "z_mm")] for r in rows]) for i, rows in roots.items()}
length = {i: np.linalg.norm(np.diff(p, axis=0), axis=1).sum() for i, p in points.items()}
total = sum(length.values())

traits = {row["trait"]: row["value"] for row in csv.DictReader(open(results / "traits.csv", newline=""))}
assert abs(float(traits["total_root_length_mm"]) / total - 1) < 1e-3
per_root = list(csv.DictReader(open(results / "per_root.csv", newline="")))
assert [int(r["root_id"]) for r in per_root] == list(roots)
assert all(abs(float(r["length_mm"]) - length[int(r["root_id"])]) < 0.01 for r in per_root)
layers = list(csv.DictReader(open(results / "depth_profile.csv", newline="")))
assert abs(sum(float(r["length_mm"]) for r in layers) / total - 1) < 1e-3
print(f"CSV: {len(roots)} roots, {total:.0f} mm, {len(traits)} traits")

rsml = results / "roots.rsml"
xmlschema.validate(rsml, schema)
tree = ElementTree.parse(rsml).getroot()
assert (tree.findtext("metadata/unit"), tree.findtext("metadata/resolution")) == ("mm", "1")
seen = 0
for plant in tree.iterfind("scene/plant"):
    for root in plant.iter("root"):
        line = np.array([[float(v) for v in p.attrib.values()] for p in root.iterfind("geometry/polyline/point")])
        i = int(root.get("id").rsplit("-", 1)[-1])
        assert list(root.find("geometry/polyline/point").attrib) == ["x", "y", "z"]
        assert np.abs(line - points[i]).max() < 1e-3, i
        diameter = root.find("functions/function[@name='diameter']")
        assert diameter.get("domain") == "polyline" and len(diameter) == len(line)
        for child in root.iterfind("root"):
            start = child.find("geometry/polyline/point").attrib
            at = np.array([float(start[c]) for c in "xyz"])
            node = line[int(float(child.findtext("properties/parent-node")))]
            assert np.linalg.norm(line - at, axis=1).min() >= np.linalg.norm(node - at) - 1e-3
        seen += 1
assert seen == len(roots)
print(f"RSML: valid, {seen} roots")

scene = trimesh.load(results / "roots.glb")
assert len(scene.geometry) == len(roots)
volume = sum(g.volume for g in scene.geometry.values()) * 1e9
gltf = pygltflib.GLTF2().load(str(results / "roots.glb"))
ids = {node.extras["root_id"]: node.extras["order"] for node in gltf.nodes}
assert ids == {i: int(rows[0]["order"]) for i, rows in roots.items()}
tubes = trimesh.load(results / "roots.ply")
assert tubes.is_watertight and abs(tubes.volume / volume - 1) < 1e-3
assert abs(volume / float(traits["root_volume_mm3"]) - 1) < 0.03, (volume, traits["root_volume_mm3"])
head = (results / "centrelines.ply").read_bytes().split(b"end_header")[0].decode()
assert f"element vertex {sum(map(len, points.values()))}\n" in head
print(f"glTF, PLY: {len(ids)} tubes, watertight, {volume:.0f} mm3")

morphio.set_maximum_warnings(0)
swc = morphio.Morphology(str(results / "roots.swc"))
cable = sum(np.linalg.norm(np.diff(s.points, axis=0), axis=1).sum() for s in swc.iter())
# SWC has no unseen ties: the way from a parent to a lateral that comes from the hidden crown is drawn.
parents = {i: int(rows[0]["parent_id"]) for i, rows in roots.items() if rows[0]["parent_id"] != "-1"}
ties = sum(np.linalg.norm(points[p] - points[i][0], axis=1).min() for i, p in parents.items())
assert abs(cable / (total + ties) - 1) < 0.005, (cable, total, ties)
print(f"SWC: {len(swc.sections)} sections, {cable:.0f} mm")

group = zarr.open_group(results / "volume.ome.zarr", mode="r")
labels = group["labels/roots/0"][:]
found = set(np.unique(labels).tolist()) - {0}
assert found <= {i + 1 for i in roots} and len(found) >= 0.95 * len(roots), (len(found), len(roots))
image = group["labels/roots"].attrs["ome"]["multiscales"][0]["datasets"][0]["coordinateTransformations"]
scale, shift = np.array(image[0]["scale"]), np.array(image[1]["translation"])
right = 0
for i, p in points.items():
    at = np.round((p[:, ::-1] - shift) / scale).astype(int)
    inside = ((at >= 0) & (at < labels.shape)).all(axis=1)
    right += (labels[tuple(at[inside].T)] > 0).sum()
assert right > 0.99 * sum(map(len, points.values())), right
print(f"label image: {len(found)} roots by number")
