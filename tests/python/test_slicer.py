# SPDX-License-Identifier: Apache-2.0
"""Tests the calculation of the module for 3D Slicer, without Slicer, and the layout of the module."""
import ast
import os
import sys

import numpy as np
import pytest

import osteon

MODULE = os.path.join(os.environ["OSTEON_SOURCE"], "examples", "slicer", "OsteonReaming")
FLIP = np.diag([-1.0, -1.0, 1.0, 1.0])


@pytest.fixture
def reaming(monkeypatch):
    monkeypatch.syspath_prepend(MODULE)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    from OsteonReamingLib import reaming as made  # pylint: disable=import-outside-toplevel
    return made


@pytest.fixture
def ct():
    return osteon.phantom.ct("glenoid")


def matrix_of(ct):
    to_lps = np.diag(list(ct.geometry.spacing_mm) + [1.0])
    to_lps[:3, 3] = ct.geometry.origin_mm
    return FLIP @ to_lps


def landmarks(ct, radius=12.0):
    """Returns points around the glenoid of a phantom, a medial point, and the glenoid's centre and axis, in RAS."""
    glenoid = osteon.Glenoid.of_meta(ct.meta)
    centre = np.array([osteon.to_mm(v) for v in glenoid.at_pm])
    axis = np.array(glenoid.axis) / np.linalg.norm(glenoid.axis)
    u = np.cross(axis, [0, 0, 1])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    rim = [centre - 2 * axis + radius * (np.cos(t) * u + np.sin(t) * v) for t in np.arange(0, 2 * np.pi, np.pi / 3)]
    return np.array(rim) @ FLIP[:3, :3], (centre + 30 * axis) @ FLIP[:3, :3], centre @ FLIP[:3, :3], \
        axis @ FLIP[:3, :3]


def test_face_and_bone(reaming, backend, ct):
    rim, medial, centre, axis = landmarks(ct)
    tool = reaming.tool_mesh(diameter_mm=30)
    result = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, tool)
    assert result.axis_ras == pytest.approx(axis, abs=1e-6)
    off = result.centre_ras - centre
    assert np.linalg.norm(off - (off @ axis) * axis) < 1e-5 and abs(off @ axis) < 1  # on the axis, at the face
    # repeats the reaming with the package and without the module
    bone, cutter = backend.bone(ct), backend.voxelize(osteon.phantom.tool("reamer", diameter_mm=30))
    before = bone.voxels()
    face = osteon.Glenoid.of(np.round(result.centre_ras @ FLIP[:3, :3], 6), result.axis_ras @ FLIP[:3, :3])
    totals = osteon.World(bone, [cutter]).run(osteon.Path.builtin("glenoid-ream", face, cutter).turned(200))
    assert np.array_equal(result.bone, bone.voxels())
    assert result.voxels == totals.removed_voxels == int(result.removed.sum()) > 1000
    assert np.array_equal(result.removed == 1, (before > 0) & (result.bone == 0))
    assert sum(result.by_class.values()) == result.voxels
    assert result.volume_mm3 == pytest.approx(result.voxels * 0.47 ** 3)
    assert np.allclose(result.ijk_to_ras, matrix_of(bone.download()))


def test_any_order_of_the_axes(reaming, ct):
    """A CT whose rows, columns or slices are stored in the other direction must give the same bone."""
    rim, medial, _, _ = landmarks(ct)
    tool = reaming.tool_mesh(diameter_mm=30)
    expected = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, tool)
    for axis in range(3):
        flip = np.eye(4)
        flip[axis, axis], flip[axis, 3] = -1, ct.geometry.dims[axis] - 1
        turned = reaming.ream(np.flip(ct.voxels, 2 - axis), matrix_of(ct) @ flip, rim, medial, tool)
        assert np.array_equal(turned.bone, expected.bone) and np.allclose(turned.ijk_to_ras, expected.ijk_to_ras)
    swapped = reaming.ream(ct.voxels.transpose(0, 2, 1), matrix_of(ct)[:, [1, 0, 2, 3]], rim, medial, tool)
    assert np.array_equal(swapped.bone, expected.bone)


def test_depth_mask_and_model(reaming, ct):
    rim, medial, _, axis = landmarks(ct)
    mesh = osteon.phantom.tool("reamer", diameter_mm=30)
    model = reaming.tool_mesh(mesh.vertices_pm * 1e-9 @ FLIP[:3, :3], mesh.triangles)
    assert np.array_equal(model.vertices_pm, mesh.vertices_pm) and np.array_equal(model.triangles, mesh.triangles)
    expected = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, reaming.tool_mesh(diameter_mm=30))
    result = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, model)
    assert np.array_equal(result.bone, expected.bone)  # a tool given as a model of Slicer, in RAS
    deepest = {}
    for depth in (1.0, 3.0, 5.0):
        result = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, model, depth_mm=depth)
        k, j, i = np.nonzero(result.removed)
        points = (result.ijk_to_ras @ np.array([i, j, k, np.ones(len(i))]))[:3].T
        deepest[depth] = ((points - result.centre_ras) @ axis).max()
        assert deepest[depth] == pytest.approx(depth, abs=1.0)  # the allowed error is the size of the voxels
    assert deepest[1.0] + 1.5 < deepest[3.0] < deepest[5.0] - 1.5
    half = np.ones(ct.voxels.shape, np.uint8)
    half[:ct.voxels.shape[0] // 2] = 0
    masked = reaming.ream(ct.voxels, matrix_of(ct), rim, medial, model, mask=half)
    assert 0 < masked.voxels < 0.8 * expected.voxels
    k = np.nonzero(masked.removed)[0].min()
    assert k * 0.47 >= (ct.voxels.shape[0] // 2 - 1) * 1.0


def test_errors(reaming, ct):
    rim, medial, centre, axis = landmarks(ct)
    tool = reaming.tool_mesh(diameter_mm=30)

    def fails(part, rim=rim, medial=medial, **options):
        with pytest.raises(ValueError, match=part):
            reaming.ream(ct.voxels, matrix_of(ct), rim, medial, tool, **options)

    fails("2 points on the rim", rim=rim[:2])
    fails("lie on a line", rim=[centre, centre + [0, 0, 5], centre + [0, 0, 9]])
    fails("medial point is 0.0 mm", medial=rim.mean(axis=0))
    fails("no bone within 10 mm", rim=rim - 60 * axis)
    fails("no bone within 10 mm", medial=centre - 30 * axis)  # a point on the lateral side reverses the axis
    fails("depth of 20", depth_mm=20)
    fails("mask of shape", mask=np.zeros((1, 1, 1)))
    oblique = np.eye(4)
    oblique[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    with pytest.raises(ValueError, match="oblique"):
        reaming.ream(ct.voxels, matrix_of(ct) @ oblique, rim, medial, tool)


def test_layout():
    """The file of the module must define the classes that Slicer searches for, and CMake must install its files."""
    with open(os.path.join(MODULE, "OsteonReaming.py"), encoding="utf-8") as file:
        tree = ast.parse(file.read())
    found = {node.name: [base.id for base in node.bases] for node in tree.body if isinstance(node, ast.ClassDef)}
    assert found == {"OsteonReaming": ["ScriptedLoadableModule"],
                     "OsteonReamingWidget": ["ScriptedLoadableModuleWidget"],
                     "OsteonReamingLogic": ["ScriptedLoadableModuleLogic"],
                     "OsteonReamingTest": ["ScriptedLoadableModuleTest"]}
    with open(os.path.join(MODULE, "CMakeLists.txt"), encoding="utf-8") as file:
        text = file.read().replace("${MODULE_NAME}", "OsteonReaming")
    for folder, _, names in os.walk(MODULE):
        for name in names:
            if name.endswith(".py"):
                assert os.path.relpath(os.path.join(folder, name), MODULE) in text
