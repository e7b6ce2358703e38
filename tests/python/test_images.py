# SPDX-License-Identifier: Apache-2.0
"""Tests that images of SimpleITK and nibabel have the voxels and the geometry that the library reads from the file."""
import itertools
import sys

import numpy as np
import pytest

import osteon


def same(a, b):
    assert a.geometry == b.geometry
    assert np.array_equal(a.voxels, b.voxels)


@pytest.fixture
def volume():
    rng = np.random.default_rng(5)
    voxels = rng.integers(-1000, 3000, (3, 4, 5), dtype=np.int16)
    return osteon.Volume(voxels, osteon.Geometry.of(voxels.shape, (0.47, 0.5, 1.25), (-57.34, 12, 3.5)))


def test_sitk(tmp_path, volume):
    sitk = pytest.importorskip("SimpleITK")
    image = volume.to_sitk()
    assert image.GetSize() == (5, 4, 3) and image.GetSpacing() == (0.47, 0.5, 1.25)
    same(osteon.Volume.from_sitk(image), volume)
    sitk.WriteImage(image, str(tmp_path / "s.nrrd"))
    same(osteon.Volume.read(tmp_path / "s.nrrd"), volume)
    oblique = volume.to_sitk()
    oblique.SetDirection((0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1))
    with pytest.raises(osteon.InputError, match="oblique"):
        osteon.Volume.from_sitk(oblique)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_sitk_directions(tmp_path, volume, order):
    sitk = pytest.importorskip("SimpleITK")
    for signs in itertools.product((1, -1), repeat=3):
        matrix = np.zeros((3, 3))
        for b, a in enumerate(order):
            matrix[a, b] = signs[b]
        image = volume.to_sitk()
        image.SetDirection(matrix.ravel().tolist())
        sitk.WriteImage(image, str(tmp_path / "d.nrrd"))
        same(osteon.Volume.from_sitk(image), osteon.Volume.read(tmp_path / "d.nrrd"))


def test_nibabel(tmp_path, volume, inputs):
    nibabel = pytest.importorskip("nibabel")
    image = volume.to_nibabel()
    assert np.shares_memory(np.asanyarray(image.dataobj), volume.voxels)
    same(osteon.Volume.from_nibabel(image), volume)
    nibabel.save(image, tmp_path / "n.nii.gz")
    same(osteon.Volume.from_nibabel(nibabel.load(tmp_path / "n.nii.gz")), volume)
    same(osteon.Volume.read(tmp_path / "n.nii.gz"), volume)
    same(osteon.Volume.from_nibabel(nibabel.load(inputs / "ct.nii.gz")), osteon.Volume.read(inputs / "ct.nii.gz"))
    oblique = nibabel.Nifti1Image(volume.voxels.T, np.array([[.8, -.6, 0, 0], [.6, .8, 0, 0], [0, 0, 1, 0],
                                                             [0, 0, 0, 1]]))
    with pytest.raises(osteon.InputError, match="oblique"):
        osteon.Volume.from_nibabel(oblique)


def test_arrays_become_bones(backend, volume):
    plain = backend.bone(volume, cubic_mm="0.5").digest()
    assert backend.bone(volume.voxels, geometry=volume.geometry, cubic_mm="0.5").digest() == plain
    with pytest.raises(osteon.UsageError, match="geometry"):
        backend.bone(volume.voxels)


@pytest.mark.parametrize("package, convert", [("SimpleITK", "to_sitk"), ("nibabel", "to_nibabel")])
def test_images_become_bones(backend, volume, package, convert):
    pytest.importorskip(package)
    image = getattr(volume, convert)()
    assert backend.bone(image, cubic_mm="0.5").digest() == backend.bone(volume, cubic_mm="0.5").digest()


def test_missing_packages(volume, monkeypatch):
    for name, convert in (("SimpleITK", volume.to_sitk), ("nibabel", volume.to_nibabel),
                          ("trimesh", osteon.phantom.tool("peg").to_trimesh)):
        monkeypatch.setitem(sys.modules, name, None)  # an import of this name fails
        with pytest.raises(osteon.UnavailableError, match=f"pip install {name}"):
            convert()


def test_trimesh(backend, inputs):
    trimesh = pytest.importorskip("trimesh")
    read = osteon.Mesh.read(inputs / "peg.stl")
    assert backend.voxelize(read.to_trimesh()).digest() == backend.read_tool(inputs / "peg.stl").digest()
    box = trimesh.creation.box((4, 6, 8))
    tool = backend.voxelize(box, "1")
    assert tool.report["cutting_voxels"] == 4 * 6 * 8
    assert osteon.Mesh.from_trimesh(box).volume_mm3 == pytest.approx(192)
