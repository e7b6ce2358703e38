# SPDX-License-Identifier: Apache-2.0
"""Tests that osteon.diff returns the same verdict, counts and classes as the command."""
import numpy as np
import pytest

import osteon


def test_bones_before_and_after(tmp_path, scene, command):
    bone, tool, path = scene
    bone.write(tmp_path / "a.nrrd")
    start = bone.copy()
    totals = osteon.World(bone, [tool]).run(path)
    bone.write(tmp_path / "b.nrrd")
    found = osteon.diff(start, bone)
    reported = command.json("diff", tmp_path / "a.nrrd", tmp_path / "b.nrrd", status=1)
    assert not found and found.different == totals.removed_voxels == reported["different_voxels"]
    assert found.by_kind == {c["name"]: c["voxels"] for c in reported["classes"]}
    assert found.pattern == reported["pattern"]
    assert [p._asdict() for p in found.patterns] == reported["patterns"]
    assert [(list(c.chunk), c.different) for c in found.chunks] == [
        (c["chunk"], c["different_voxels"]) for c in reported["chunks"]]
    assert "only-removed" in str(found) and f"{found.different} voxels" in str(found)
    files = osteon.diff(tmp_path / "a.nrrd", str(tmp_path / "b.nrrd"))
    assert (files.different, files.pattern, files.first) == (found.different, found.pattern, found.first)
    assert osteon.diff(bone, tmp_path / "b.nrrd") and str(osteon.diff(bone, bone)) == "equal"


def grid(voxels, **geometry):
    voxels = np.asarray(voxels, np.int16)
    return osteon.Volume(voxels, osteon.Geometry.of(voxels.shape, geometry.get("spacing", 1),
                                                    geometry.get("origin", (0, 0, 0))))


def test_kinds_box_and_first():
    a = np.zeros((40, 8, 8), np.int16)
    a[:, 2, 3] = 500
    b = a.copy()
    b[39, 2, 3], b[5, 2, 3], b[0, 0, 0], b[33, 7, 7] = 0, 600, 10, 900
    found = osteon.diff(grid(a), grid(b), limit=2)
    assert found.by_kind == {"removed": 1, "added": 1, "changed": 1, "below": 1}
    assert found.box == ((0, 0, 0), (8, 8, 40))
    assert found.first == [((0, 0, 0), 0, 10), ((3, 2, 5), 500, 600)]
    assert [(c.chunk, c.different) for c in found.chunks] == [((0, 0, 0), 2), ((0, 0, 1), 2)]


@pytest.mark.parametrize("change, pattern", [
    (lambda v: v.byteswap(), "byte-order"), (lambda v: v.transpose(2, 1, 0), "axis-swap"),
    (lambda v: np.where(v > 0, v + 5, v), "offset"), (lambda v: np.where(v < 300, 0, v), "threshold"),
])
def test_classes(change, pattern):
    rng = np.random.default_rng(1)
    voxels = rng.integers(150, 3000, (20, 20, 20), dtype=np.int16)
    assert osteon.diff(grid(voxels), grid(np.ascontiguousarray(change(voxels)))).pattern == pattern


def test_geometry():
    v = np.full((3, 4, 5), 500)
    assert osteon.diff(grid(v), grid(v, spacing=1.00000001)).rounded_geometry
    moved = osteon.diff(grid(v), grid(v, origin=(0.1, 0, 0)))
    assert not moved and not moved.same_origin and moved.patterns == [
        ("geometry", "origin (0, 0, 0) against (0.1, 0, 0) mm")]
    other = osteon.diff(grid(v), grid(v[:2]))
    assert not other.same_dims and other.patterns[0].text == "dims 5 x 4 x 3 against 5 x 4 x 2"
    with pytest.raises(osteon.UsageError):
        osteon.diff(grid(v), grid(v + 1), chunk_size=5)


def test_tools(tmp_path, backend, inputs, command):
    tools = [backend.read_tool(inputs / "peg.stl", voxel) for voxel in ("0.5", "0.5", "0.6")]
    assert osteon.diff(tools[0], tools[1])
    voxels = tools[0].voxels().copy()
    voxels[3, 4:9, 5] = 2
    changed = osteon.ToolVolume(voxels, tools[0].geometry)
    changed.write(tmp_path / "b.nrrd")
    tools[0].write(tmp_path / "a.nrrd")
    reported = command.json("diff", tmp_path / "a.nrrd", tmp_path / "b.nrrd", status=1)
    found = osteon.diff(tools[0], tmp_path / "b.nrrd")
    assert (found.pattern, found.different) == (reported["pattern"], reported["different_voxels"]) == ("tool-class", 5)
    assert not osteon.diff(tools[0], tools[2]).same_dims
    with pytest.raises(osteon.UsageError):
        osteon.diff(tools[0], inputs / "bone.nrrd")
