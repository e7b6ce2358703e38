# SPDX-License-Identifier: Apache-2.0
"""Fixtures: generated inputs as files, backends, and the osteon command of the build folder."""
import json
import os
import subprocess

import pytest

import osteon


class Command:
    """Runs the osteon command."""

    def __init__(self, program):
        self.program = program

    def __call__(self, *arguments, status=0):
        done = subprocess.run([self.program, *(str(a) for a in arguments)], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout

    def json(self, *arguments, status=0):
        """Runs the command with --json and returns the object that it prints."""
        return json.loads(self(*arguments, "--json", status=status))


@pytest.fixture(scope="session")
def command():
    return Command(os.environ["OSTEON"])


@pytest.fixture(scope="session")
def inputs(tmp_path_factory, command):
    """A folder with a generated CT (NRRD and NIfTI), a bone, and two meshes, all written by the command."""
    folder = tmp_path_factory.mktemp("inputs")
    command("phantom", "glenoid", "--out", folder / "ct.nrrd")
    command("phantom", "glenoid", "--out", folder / "ct.nii.gz")
    command("import", folder / "ct.nrrd", "--out", folder / "bone.nrrd")
    command("tool", "peg", "--out", folder / "peg.stl")
    command("tool", "reamer", "--out", folder / "reamer.stl")
    return folder


@pytest.fixture
def backend():
    with osteon.Backend("cpu:threads=2") as made:
        yield made


@pytest.fixture
def scene(backend, inputs):
    """A bone, a peg and a path of a peg hole."""
    bone = backend.read_bone(inputs / "ct.nrrd")
    tool = backend.read_tool(inputs / "peg.stl")
    path = osteon.Path.builtin("peg-hole", osteon.Glenoid.of_meta(bone.meta), tool).turned()
    return bone, tool, path
