# SPDX-License-Identifier: Apache-2.0
"""Compares segmentation, spheres and landmarks with the results of the command."""
import numpy as np
import pytest

import osteon
from osteon import anatomy, segmentation


@pytest.fixture(scope="module")
def scapula(tmp_path_factory, command):
    folder = tmp_path_factory.mktemp("scapula")
    command("phantom", "scapula", "--spacing", "1,1,1", "--out", folder / "ct.nrrd")
    return folder / "ct.nrrd"


@pytest.fixture(scope="module")
def shoulder(tmp_path_factory, command):
    folder = tmp_path_factory.mktemp("shoulder")
    command("phantom", "shoulder", "--spacing", "1,1,1", "--out", folder / "ct.nrrd")
    return folder / "ct.nrrd"


def mm(point):
    return [osteon.to_mm(v) for v in point]


def test_landmarks_equal_command(tmp_path, backend, scapula, command):
    report = command.json("import", scapula, "--landmarks", "auto", "--out", tmp_path / "bone.nrrd")
    expected = report["landmarks_proposed"]
    bone = backend.read_bone(scapula)
    found = anatomy.landmarks(bone)
    assert mm(found.glenoid.at_pm) == expected["glenoid_mm"] and list(found.glenoid.axis) == expected["axis"]
    assert mm(found.trigonum_pm) == expected["trigonum_mm"] and found.glenoid.side == expected["side"]
    assert mm(found.inferior_angle_pm) == expected["inferior_angle_mm"]
    assert osteon.to_mm(found.height_pm) == expected["height_mm"]
    assert osteon.to_mm(found.width_pm) == expected["width_mm"]
    assert osteon.to_mm(found.curvature.radius_pm) == expected["curvature_mm"]
    for name in ("rim_share", "rim_residual_mm", "glenoid_spread_mm", "axis_spread_deg", "trigonum_spread_mm"):
        assert getattr(found, name) == pytest.approx(expected[name]), name
    meta = found.meta()
    for name in ("glenoid_at_mm", "trigonum_mm", "inferior_angle_mm", "side"):
        assert meta[name] == report["meta"][name]
    angles = osteon.metrics.Plan.of_meta(meta).angles_deg
    assert angles == pytest.approx((report["version_deg"], report["inclination_deg"]), abs=1e-4)
    assert osteon.Glenoid.of_meta(meta) == found.glenoid
    again = anatomy.rim(bone, found.glenoid)
    assert again.shape[1] == 3 and len(again) > 36 and len(found.rim_pm) == pytest.approx(72 * found.rim_share)
    distance = np.linalg.norm((again - found.glenoid.at_pm) / osteon.PM_PER_MM, axis=1)
    assert 10 < distance.min() and distance.max() < 25


@pytest.fixture(scope="module")
def blocks():
    """Returns a CT of two blocks with a hole (one with air), two small blocks, a dumbbell, and a soft rim."""
    hu = np.full((40, 40, 90), -1000, np.int16)
    hu[2:18, 2:18, 2:18] = 500
    hu[8:10, 8:10, 8:10] = 50
    hu[2:18, 22:38, 2:18] = 600
    hu[8:10, 28:30, 8:10] = -500
    hu[30:34, 2:6, 2:7] = 700  # 80 mm3
    hu[30:33, 12:15, 2:5] = 700  # 27 mm3
    z, y, x = np.indices(hu.shape)
    for end in (35, 60):
        hu[(z - 20)**2 + (y - 20)**2 + (x - end)**2 <= 100] = 800
    hu[(z - 20)**2 + (y - 20)**2 <= 9] = np.where(abs(x - 47) < 12, 800, hu)[(z - 20)**2 + (y - 20)**2 <= 9]
    hu[2:18, 2:18, 18:20] = 110
    return osteon.Volume(hu, osteon.Geometry.of(hu.shape, 1, (-10, 5, "2.5")))


@pytest.mark.parametrize("options, keywords, count, filled", [
    ([], {}, 3, 0),
    (["--min-volume", "50"], {"min_volume_mm3": 50}, 4, 0),
    (["--min-volume", "0"], {"min_volume_mm3": 0}, 5, 0),
    (["--threshold", "650"], {"threshold": 650}, 1, 0),
    (["--growth", "100"], {"growth": 100}, 3, 0),
    (["--fill"], {"fill": True}, 3, 8),
    (["--fill", "--air", "-600"], {"fill": True, "air": -600}, 3, 16),
    (["--separate", "4"], {"separate_mm": 4}, 4, 0),
    (["--cut-ball", "37,25,22.5,6"], {"cuts": [segmentation.Cut.ball((37, 25, "22.5"), 6)]}, 4, 0),
    (["--cut-plane", "40,0,0,2,0,0.5"], {"cuts": [segmentation.Cut.plane((40, 0, 0), (2, 0, 0.5))]}, 3, 0),
])
def test_segmentation_equals_command(tmp_path, blocks, command, options, keywords, count, filled):
    blocks.write(tmp_path / "ct.nrrd")
    command("segment", tmp_path / "ct.nrrd", "--out", tmp_path / "labels.nrrd", *options)
    found, expected = segmentation.segment(blocks, **keywords), osteon.Volume.read(tmp_path / "labels.nrrd")
    assert np.array_equal(found.labels.voxels, expected.voxels) and found.labels.geometry == blocks.geometry
    assert len(found.segments) == expected.voxels.max() == count
    for number, each in enumerate(found.segments):
        at = np.argwhere(found.mask(number + 1))[:, ::-1]
        assert len(at) == each.voxels + each.filled and each.first in set(map(tuple, at.tolist()))
        assert (at.min(axis=0) >= each.box[0]).all() and (at.max(axis=0) < each.box[1]).all()
    assert sum(each.filled for each in found.segments) == filled


def test_labels(shoulder):
    ct = osteon.Volume.read(shoulder)
    head = anatomy.spheres(ct, most=1)[0]
    found = segmentation.segment(ct, cuts=[segmentation.Cut.ball(mm(head.centre_pm), osteon.to_mm(head.radius_pm) + 2)])
    assert len(found.segments) >= 2
    x, y, z = found.segments[1].first
    g = ct.geometry
    at = [osteon.mm_text(o + n * s) for o, n, s in zip(g.origin_pm, (x, y, z), g.spacing_pm)]
    assert found.label_at(at) == 2 and found.label_at((4000, 0, 0)) is None
    assert found.label_near(at) == (2, osteon.pm3(at))
    kept = found.keep([2])
    assert kept.segments == [found.segments[1]] and kept.label_at(at) == 1
    assert np.array_equal(kept.labels.voxels == 1, found.mask(2)) and found.labels.voxels.max() == len(found.segments)
    nothing = kept.keep([])
    assert nothing.segments == [] and not nothing.labels.voxels.any()
    with pytest.raises(osteon.UsageError, match="label"):
        nothing.label_near(at)
    with pytest.raises(osteon.UsageError, match="expected 1 to"):
        found.keep([0])
    with pytest.raises(osteon.RangeError):
        segmentation.segment(ct, threshold=0x8000)
    with pytest.raises(osteon.RangeError):
        segmentation.segment(ct, cuts=[segmentation.Cut((0, 0, 0))])


def test_spheres(shoulder):
    ct = osteon.Volume.read(shoulder)
    found = anatomy.spheres(ct)
    assert found == sorted(found, key=lambda s: -s.coverage) and 17 <= osteon.to_mm(found[0].radius_pm) <= 32
    near = anatomy.spheres(ct, near_mm=mm(found[0].centre_pm), reach_mm=5, most=1)
    assert near == found[:1]
    # a point 2 mm inside the sphere must be bone
    centre = (np.array(found[0].centre_pm) - ct.geometry.origin_pm) / ct.geometry.spacing_pm
    inside = centre + (osteon.to_mm(found[0].radius_pm) - 2) * np.array(found[0].facing)
    assert ct.voxels[tuple(np.rint(inside[::-1]).astype(int))] >= 120
    labels = osteon.Volume((ct.voxels >= 120).astype(np.int16) * 7, ct.geometry)
    assert anatomy.spheres(labels, label=7, most=1)[0].radius_pm == pytest.approx(found[0].radius_pm, rel=0.05)
    with pytest.raises(osteon.RangeError):
        anatomy.spheres(ct, radius_mm=(1, 2))
    with pytest.raises(osteon.InputError):
        anatomy.spheres(labels, label=3)
    with pytest.raises(osteon.UsageError):
        anatomy.spheres(labels, label=3, threshold=120)
    with pytest.raises(osteon.InputError):
        anatomy.landmarks(osteon.phantom.ct("trabecular"))


def test_landmark_files(tmp_path):
    items = [anatomy.Landmark("Glenoid", osteon.pm3(("1.25", "-2", "3"))),
             anatomy.Landmark("TS", (1, 2, 3)), anatomy.Landmark("something", (0, 0, -5))]
    anatomy.write_landmarks(tmp_path / "l.mrk.json", items)
    read = anatomy.read_landmarks(tmp_path / "l.mrk.json")
    assert [item[:2] for item in read] == [item[:2] for item in items]
    assert [item.role for item in read] == ["glenoid", "trigonum", "other"]
    (tmp_path / "l.csv").write_text("label,x,y,z\nIA,1,2,3.5\n")
    assert anatomy.read_landmarks(tmp_path / "l.csv") == [
        anatomy.Landmark("IA", osteon.pm3((1, 2, "3.5")), "inferior angle")]
    with pytest.raises(osteon.InputError):
        (tmp_path / "e.csv").write_text("label,x,y,z\n")
        anatomy.read_landmarks(tmp_path / "e.csv")
    with pytest.raises(osteon.FileError):
        anatomy.write_landmarks(tmp_path / "none" / "l.mrk.json", items)
