# SPDX-License-Identifier: Apache-2.0
"""Tests pictures as arrays, phantoms, and the code in the documents."""
import doctest
import importlib
import os
import pkgutil
import re
import subprocess
import sys

import numpy as np
import pytest

import osteon


def test_render_equals_command(tmp_path, scene, command):
    bone, tool, path = scene
    bone.write(tmp_path / "a.nrrd")
    start = bone.copy()
    osteon.World(bone, [tool]).run(path)
    bone.write(tmp_path / "b.nrrd")
    picture = osteon.render(bone, start, size=(320, 200))
    assert picture.shape == (200, 320, 3) and picture.dtype == np.uint8 and picture.std() > 5
    assert not np.array_equal(picture, osteon.render(start, size=(320, 200)))  # the cut surface is coloured
    slices = osteon.slices(bone, start)
    assert slices.ndim == 3 and slices.std() > 5
    try:
        osteon.write_png(tmp_path / "p.png", slices)
    except osteon.UnavailableError as error:
        pytest.skip(str(error))  # a build without libpng
    command("export", tmp_path / "b.nrrd", "--slices", "--before", tmp_path / "a.nrrd", "--out", tmp_path / "c.png")
    assert (tmp_path / "p.png").read_bytes() == (tmp_path / "c.png").read_bytes()


def test_other_grids(backend):
    tool = backend.voxelize(osteon.phantom.tool("burr"))
    assert osteon.render(tool, size=(64, 48)).shape == (48, 64, 3)
    volume = osteon.phantom.ct("glenoid", spacing_mm="1")
    assert osteon.render(volume, size=(64, 48), legend=False, direction=(1, 0, 0), up=(0, 0, 1)).std() > 1
    with pytest.raises(osteon.OsteonError):
        osteon.render(volume, size=(-1, 5))
    with pytest.raises(osteon.UsageError):
        osteon.write_png("none.png", np.zeros((3, 3)))


def test_points():
    hu = np.zeros((9, 9, 9), np.int16)
    hu[4, 4, 4] = 1000
    volume = osteon.Volume(hu, osteon.Geometry.of(hu.shape, 2, (-8, -8, -8)))  # one voxel of 2 mm, centred at 0
    camera = osteon.Camera.look_at((0, -101, 0), (0, 0, 0), focal_px=1000, size=(80, 60))
    picture = osteon.points(volume, camera, style="faces")
    assert picture.shape == (60, 80, 3) and picture.dtype == np.uint8
    row, column = np.nonzero((picture != picture[0, 0]).any(axis=2))
    assert (row.min(), row.max(), column.min(), column.max()) == (20, 39, 30, 49)  # 2 mm at 100 mm: 20 pixels
    aside = osteon.points(volume, osteon.Camera.look_at((0, -101, 1), (0, 0, 1), focal_px=1000, size=(80, 60)))
    assert np.nonzero((aside != aside[0, 0]).any(axis=2))[0].min() == 30  # the camera is 1 mm higher
    bone = osteon.phantom.ct("glenoid", spacing_mm="1")
    camera = osteon.Camera.look_at((-300, -18, 54), (-148, -18, 54), size=(120, 100))
    pictures = [osteon.points(bone, camera, threads=n, style=style) for style in ("smooth", "faces") for n in (1, 2)]
    assert np.array_equal(*pictures[:2]) and np.array_equal(*pictures[2:]) and pictures[0].std() > 5
    assert not np.array_equal(pictures[0], pictures[2])
    assert not np.array_equal(pictures[0], osteon.points(bone, camera, threshold=600))
    with pytest.raises(osteon.UsageError, match="style"):
        osteon.points(bone, camera, style="x")
    with pytest.raises(osteon.RangeError):
        osteon.points(bone, camera._replace(focal_px=0))
    with pytest.raises(osteon.OsteonError):
        osteon.Camera.look_at((0, 0, 0), (0, 0, 0))


def test_phantoms(tmp_path, inputs, command):
    volume = osteon.phantom.ct("glenoid")
    volume.write(tmp_path / "ct.nrrd")
    assert (tmp_path / "ct.nrrd").read_bytes() == (inputs / "ct.nrrd").read_bytes()
    osteon.phantom.tool("reamer").write_stl(tmp_path / "r.stl")
    assert (tmp_path / "r.stl").read_bytes() == (inputs / "reamer.stl").read_bytes()
    for wrong in (lambda: osteon.phantom.ct("x"), lambda: osteon.phantom.tool("x"),
                  lambda: osteon.phantom.tool("peg", part="x")):
        with pytest.raises(osteon.UsageError, match="expected one of"):
            wrong()


def test_examples_in_docstrings():
    for module in pkgutil.iter_modules(osteon.__path__):
        if module.name != "_osteon":
            loaded = importlib.import_module("osteon." + module.name)
            assert doctest.testmod(loaded, extraglobs={"osteon": osteon}).failed == 0
    assert doctest.testmod(osteon).attempted >= 6 and doctest.testmod(osteon).failed == 0


def test_png_in_memory(tmp_path):
    picture = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    osteon.write_png(tmp_path / "a.png", picture)
    assert osteon.encode_png(picture) == (tmp_path / "a.png").read_bytes()
    with pytest.raises(osteon.UsageError):
        osteon.encode_png(picture[0])


def blocks(name):
    """Returns the Python code of a document."""
    with open(os.path.join(os.environ["OSTEON_SOURCE"], name), encoding="utf-8") as file:
        return re.findall(r"^```python\n(.*?)^```", file.read(), re.M | re.S)


def test_code_of_the_guide(tmp_path, command):
    """Runs the code of docs/guide/python.md in order, in a folder with the files that the guide names."""
    command("phantom", "glenoid", "--out", tmp_path / "shoulder.nii.gz")
    command("tool", "reamer", "--out", tmp_path / "reamer.stl")
    code = blocks("docs/guide/python.md")
    assert len(code) >= 5
    (tmp_path / "guide.py").write_text("\n".join(code))
    subprocess.run([sys.executable, "guide.py"], cwd=tmp_path, check=True, env=dict(os.environ))
    # the file must equal the file of the command
    text = code[0]
    at = re.search(r"at_mm=\((.*?)\)", text).group(1).replace(" ", "")
    axis = re.search(r"axis=\((.*?)\)", text).group(1).replace(" ", "")
    command("ream", "--bone", tmp_path / "shoulder.nii.gz", "--tool", tmp_path / "reamer.stl", "--path",
            "builtin:glenoid-ream", "--at", at, "--axis", axis, "--out", tmp_path / "c.nrrd")
    assert (tmp_path / "reamed.nrrd").read_bytes() == (tmp_path / "c.nrrd").read_bytes()


def test_readme_example_equals_guide():
    assert blocks("README.md")[0] == blocks("docs/guide/python.md")[0]
    assert len(blocks("README.md")[0].strip().splitlines()) <= 10
