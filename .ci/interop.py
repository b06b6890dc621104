"""Opens the arrays of a store and the OME-Zarr of a result with zarr-python and checks what they hold."""

import pathlib
import sys

import numpy as np
import zarr

cache, results = map(pathlib.Path, sys.argv[1:3])

seen = 0
for stage, name, dims in [
    ("render", "view", ("z", "y", "x", "c")),
    ("merge", "merged", ("z", "y", "x", "c")),
    ("merge", "coverage", ("z", "y", "x")),
    ("rootness", "rootness", ("z", "y", "x")),
]:
    found = sorted(cache.glob(f"v*/nodes/{stage}/*/{name}/zarr.json"))
    assert found, f"no array `{name}` in the store"
    array = zarr.open_array(found[0].parent, mode="r")
    assert array.metadata.dimension_names == dims, (name, array.metadata.dimension_names)
    values = array[:]
    assert values.size and (values.dtype.kind != "f" or np.isfinite(values).any()), name
    print(f"{name}: {array.shape} {array.dtype}, dimensions {dims}")
    seen += 1
assert seen == 4

group = zarr.open_group(results / "volume.ome.zarr", mode="r")
ome = group.attrs["ome"]
assert ome["version"] == "0.5", ome
image = ome["multiscales"][0]
assert [a["name"] for a in image["axes"]] == ["c", "z", "y", "x"], image["axes"]
assert all(a["unit"] == "millimeter" for a in image["axes"] if a["type"] == "space"), image["axes"]
shapes = [group[d["path"]].shape for d in image["datasets"]]
scales = [d["coordinateTransformations"][0]["scale"] for d in image["datasets"]]
assert len(shapes) >= 2, "a pyramid has levels"
for fine, coarse, s, t in zip(shapes, shapes[1:], scales, scales[1:]):
    assert all(-(-a // 2) == b for a, b in zip(fine[1:], coarse[1:])), (fine, coarse)
    assert all(abs(b / a - 2) < 1e-9 for a, b in zip(s[1:], t[1:])), (s, t)
assert group["labels"].attrs["ome"]["labels"] == ["roots"]
labels = group["labels/roots/0"]
assert labels.shape == shapes[0][1:] and labels[:].max() > 0
print(f"volume.ome.zarr: {shapes[0]}, {len(shapes)} levels, {scales[0][1:]} mm, labels up to {labels[:].max()}")
