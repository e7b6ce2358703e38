# SPDX-License-Identifier: Apache-2.0
"""Tests units, geometries, arrays and volumes."""
from decimal import Decimal

import numpy as np
import pytest

import osteon
from osteon.grid import as_voxels


@pytest.mark.parametrize("mm, pm", [
    ("0.47", 470_000_000), (0.47, 470_000_000), (np.float32(0.47), 470_000_000), (Decimal("0.47"), 470_000_000),
    (2, 2_000_000_000), (np.int16(-3), -3_000_000_000), (0.48828125, 488_281_250), ("-57.34", -57_340_000_000),
    ("0.0000000005", 0), ("0.0000000015", 2),  # ties are rounded to the even integer
])
def test_lengths_are_exact(mm, pm):
    assert osteon.pm(mm) == pm


@pytest.mark.parametrize("mm, error", [("nan", osteon.OsteonError), (float("nan"), osteon.RangeError),
                                       (8001.0, osteon.RangeError), ("8001", osteon.RangeError),
                                       ("1 mm", osteon.InputError), (None, osteon.UsageError),
                                       (True, osteon.UsageError)])
def test_other_lengths_are_refused(mm, error):
    with pytest.raises(error):
        osteon.pm(mm)


def test_text_of_lengths():
    assert osteon.mm_text(470_000_000) == "0.47"
    assert osteon.to_mm(-57_340_000_000) == -57.34
    assert osteon.pm3("0.5") == (500_000_000,) * 3
    assert osteon.pm3((1, "2", 3.5)) == (10**9, 2 * 10**9, 3_500_000_000)


def test_geometry_states_shape_and_dims():
    g = osteon.Geometry.of((4, 3, 2), (0.5, 0.5, 1), (-1, 0, 1))
    assert g.dims == (2, 3, 4) and g.shape == (4, 3, 2)
    assert g.spacing_pm == (500_000_000, 500_000_000, 10**9) and g.origin_mm == (-1.0, 0.0, 1.0)
    g.check()
    with pytest.raises(osteon.RangeError, match="spacing|voxel"):
        osteon.Geometry((2, 3, 4), (0, 1, 1)).check()


def test_array_index_is_zyx(tmp_path):
    # density 100 x + 10 y + z at voxel (x, y, z): the text file names each voxel by its position in mm
    z, y, x = np.mgrid[:3, :4, :5]
    volume = osteon.Volume((100 * x + 10 * y + z).astype(np.int16), osteon.Geometry.of((3, 4, 5), 1))
    volume.write(tmp_path / "v.txt")
    rows = [line.split() for line in (tmp_path / "v.txt").read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 60
    for row in rows:
        i, j, k = (int(float(v)) for v in row[:3])
        assert int(row[3]) == 100 * i + 10 * j + k == volume.voxels[k, j, i]


def test_volume_does_not_copy(inputs):
    array = np.zeros((2, 3, 4), np.int16)
    volume = osteon.Volume(array, osteon.Geometry.of(array.shape, 1))
    assert volume.voxels is array
    assert np.shares_memory(np.asarray(volume), array) and np.shares_memory(np.from_dlpack(volume), array)
    read = osteon.Volume.read(inputs / "ct.nrrd")  # the array refers to the memory of the C library
    assert not read.voxels.flags.owndata and read.voxels.flags.c_contiguous and read.voxels.flags.writeable
    view = read.voxels[1:]
    total = int(view.sum())
    del read
    assert int(view.sum()) == total  # a view keeps the memory


def test_conversions_of_arrays():
    assert as_voxels(np.array([[[0.5, 1.5, -2.5]]])).tolist() == [[[0, 2, -2]]]  # half to even
    assert as_voxels(memoryview(np.arange(8, dtype=np.int16).reshape(2, 2, 2)))[1, 1, 1] == 7
    assert as_voxels(np.arange(8, dtype=">i2").reshape(2, 2, 2)).tolist()[1] == [[4, 5], [6, 7]]
    turned = np.zeros((4, 3, 2), np.int16).transpose()
    assert as_voxels(turned).flags.c_contiguous
    assert as_voxels(np.full((1, 1, 1), 40000), clamp=True).item() == 32767
    for wrong in (np.full((1, 1, 1), 40000), np.full((1, 1, 1), np.nan)):
        with pytest.raises(osteon.RangeError):
            as_voxels(wrong)
    with pytest.raises(osteon.UsageError):
        as_voxels(np.zeros((2, 2)))
    with pytest.raises(osteon.UsageError):
        as_voxels(np.zeros((1, 1, 1), complex))


class ArrayOnDevice:
    """An array whose DLPack capsule cannot be read, like a tensor on a GPU."""

    def __dlpack__(self, **_):
        raise BufferError("device 2")

    def __dlpack_device__(self):
        return 2, 0


def test_dlpack(inputs):
    class Tensor:  # an object that offers DLPack and no other interface
        def __init__(self, array):
            self.array = array

        def __dlpack__(self, **options):
            return self.array.__dlpack__(**options)

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    array = osteon.Volume.read(inputs / "ct.nrrd").voxels
    assert np.shares_memory(as_voxels(Tensor(array)), array)
    with pytest.raises(osteon.UsageError, match="copy it to the host"):
        as_voxels(ArrayOnDevice())


def test_files_and_digests(tmp_path, inputs, command):
    volume = osteon.Volume.read(inputs / "ct.nrrd")
    assert volume.meta["kind"] == "ct" and volume.report["type"] == "int16"
    volume.write(tmp_path / "again.nrrd")
    assert (tmp_path / "again.nrrd").read_bytes() == (inputs / "ct.nrrd").read_bytes()
    stages = {s["name"]: s["sha256"] for s in command.json("import", inputs / "ct.nrrd", "--out",
                                                           tmp_path / "b.nrrd")["stages"]}
    assert volume.digest("rect") == stages["rect"]
    assert osteon.sha256(b"abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_progress_can_cancel(inputs):
    seen = []
    osteon.Volume.read(inputs / "ct.nrrd", progress=lambda stage, share: seen.append((stage, share)))
    assert seen and seen[0][0] == "reading"
    with pytest.raises(osteon.CancelledError):
        osteon.Volume.read(inputs / "ct.nrrd", progress=lambda *_: False)
    with pytest.raises(ZeroDivisionError):  # an exception of the function is raised after the call
        osteon.Volume.read(inputs / "ct.nrrd", progress=lambda *_: 1 / 0)


def test_occupancy(backend, inputs):
    bone = backend.read_bone(inputs / "ct.nrrd")
    for chunk_size in (16, 32, 64):
        copy = backend.bone(bone.download(), chunk_size=chunk_size, threshold=bone.threshold)
        active = copy.occupancy()
        assert active.dtype == bool and active.flags.c_contiguous and active.sum() == copy.info.active_voxels
        assert np.array_equal(active, copy.voxels() >= bone.threshold)
    with osteon.FunctionBackend(lambda bone, tool, event: None) as slices:
        with pytest.raises(osteon.UnavailableError):
            bone.copy(slices).occupancy()


def test_facts_of_a_file(tmp_path, inputs):
    volume = osteon.Volume.read(inputs / "ct.nrrd")
    volume.write(tmp_path / "a.nrrd")
    osteon.Volume.write_meta(tmp_path / "a.nrrd", {**volume.meta, "side": "left"})
    again = osteon.Volume.read(tmp_path / "a.nrrd")
    assert again.meta["side"] == "left" and again.digest() == volume.digest()
    with pytest.raises(osteon.OsteonError):
        osteon.Volume.write_meta(inputs / "peg.stl", volume.meta)
