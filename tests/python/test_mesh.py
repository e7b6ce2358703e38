# SPDX-License-Identifier: Apache-2.0
"""Tests meshes, tool grids and voxelization."""
import numpy as np
import pytest

import osteon

CUBE = ([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)],
        [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
         [1, 3, 5], [3, 7, 5]])


def cube(mm):
    return osteon.Mesh(np.array(CUBE[0], np.int64) * osteon.pm(mm), CUBE[1])


def test_mesh_properties(tmp_path):
    mesh = cube(2)
    assert mesh.volume_mm3 == 8 and mesh.open_edges == 0
    assert mesh.bounds_pm == ((0, 0, 0), (2 * 10**9,) * 3)
    assert osteon.Mesh(mesh.vertices_pm, mesh.triangles[:-1]).open_edges == 3
    mesh.write_stl(tmp_path / "cube.stl")
    again = osteon.Mesh.read(tmp_path / "cube.stl")
    assert again.report["format"].startswith("STL") and again.volume_mm3 == 8
    with pytest.raises(osteon.RangeError):
        osteon.Mesh.of_mm([[0, 0, float("nan")]] * 3, [[0, 1, 2]])
    with pytest.raises(osteon.UsageError, match="vertex index 9"):
        osteon.Mesh(mesh.vertices_pm, [[0, 1, 9]])
    with pytest.raises(osteon.OsteonError):
        osteon.Mesh.read(tmp_path / "none.stl")


def test_voxelize_counts(backend):
    tool = backend.voxelize(cube(4), "0.5", noncutting=cube(6))
    inside = tool.voxels()
    assert (inside == 1).sum() == 8**3 == tool.report["cutting_voxels"]
    assert (inside == 2).sum() == 12**3 - 8**3
    assert tool.report["leaking_rows"] == 0


def test_tool_files(tmp_path, backend, inputs, command):
    command("voxelize", inputs / "reamer.stl", "--out", tmp_path / "c.nrrd")
    tool = backend.read_tool(inputs / "reamer.stl")
    tool.write(tmp_path / "p.nrrd")
    read = osteon.ToolVolume.read(tmp_path / "c.nrrd")
    assert np.array_equal(read.voxels, tool.voxels()) and read.geometry == tool.geometry
    assert backend.read_tool(tmp_path / "p.nrrd").digest() == tool.digest() == osteon.digest(read)
    assert tool.voxels().shape == tool.geometry.shape
    read.voxels[0, 0, 0] = 3
    with pytest.raises(osteon.OsteonError):
        backend.tool(read)
