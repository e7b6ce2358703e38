#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what osteon reads and writes with independent readers: SimpleITK, pydicom and nibabel, where installed.

    input --osteon export--> .nrrd, .nii.gz --readers--> Image   \\
      |                                                           > 1,000 random voxels: value and position
      '--------------------------readers----------> Image        /
    input --osteon import--> bone.nrrd   against linear interpolation of the reader's image

A voxel agrees if its centre lies within an eighth of a voxel of the centre of a voxel that the reader returns, both
grids have equal numbers of voxels, and the values are equal. Densities that are not integers are rounded to the
nearest integer, ties to even. A voxel of a bone agrees if it differs by at most one from the interpolated density, or if it
is 0 and the interpolated density is below the threshold. An oblique CT is imported with --resample-oblique and
--resample nearest; a voxel then agrees if its value occurs within 1.25 voxels on each axis, since both steps move by
at most half a voxel.

Usage: check_readers.py [FILE|FOLDER...]   default: generated inputs, and every CT below $INTEROP_DATA if that is set
Environment: OSTEON (default ./osteon), MAKE_SERIES (default tests/dicom/make_series), OST_TEST_SEED.
Prints a line per input. Exit status 1 if anything differs, 77 if none of the packages is installed.

Covers: REQ-INTEROP
"""

import itertools
import os
import random
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
SKIP = 77
try:
    import numpy as np
    import readers
except ImportError:
    print("skipped: numpy is not installed")
    sys.exit(SKIP)

OSTEON = os.path.abspath(os.environ.get("OSTEON", "osteon"))
MAKE_SERIES = os.path.abspath(os.environ.get("MAKE_SERIES", "tests/dicom/make_series"))
VOXELS = 1000
SEED = int(os.environ.get("OST_TEST_SEED") or random.randrange(2**32))
rng = np.random.default_rng(SEED)


def osteon(*arguments):
    """Returns the error text, or None on success."""
    done = subprocess.run([OSTEON, *arguments], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 2, 3):
        return f"exit status {done.returncode}: {done.stderr.strip()}"
    return None if done.returncode == 0 else done.stderr.strip() or "no message"


def positions(image, indices):
    return indices @ image.affine[:3, :3].T + image.affine[:3, 3]


def indices_at(image, points):
    return np.linalg.solve(image.affine[:3, :3], (points - image.affine[:3, 3]).T).T


def random_indices(image):
    return np.stack([rng.integers(0, n, VOXELS) for n in image.values.shape], axis=1)


def compare(ours, theirs):
    """Compares random voxels. Returns (description of a difference or None, greatest distance of two centres in mm)."""
    if sorted(ours.values.shape) != sorted(theirs.values.shape):
        return f"{ours.values.shape} voxels, not {theirs.values.shape}", 0
    at = random_indices(ours)
    points = positions(ours, at)
    exact = indices_at(theirs, points)
    nearest = np.rint(exact).astype(int)
    off = np.abs(exact - nearest).max(axis=1)
    if (nearest < 0).any() or (nearest >= theirs.values.shape).any() or off.max() > 0.125:
        return f"a voxel lies at {points[off.argmax()]}, {off.max():.3f} voxels away from the nearest one", 0
    expected = np.rint(theirs.values[tuple(nearest.T)].astype(float))
    found = ours.values[tuple(at.T)]
    wrong = found != expected
    if wrong.any():
        w = wrong.argmax()
        return f"{wrong.sum()} values differ; at {points[w]}: {found[w]}, expected {expected[w]}", 0
    return None, np.linalg.norm(positions(theirs, nearest) - points, axis=1).max()


def interpolate(image, points):
    """Interpolates linearly between voxel centres. Outside of the outermost centres, the nearest values are used."""
    at = indices_at(image, points)
    low = np.clip(np.floor(at), 0, np.maximum(np.array(image.values.shape) - 2, 0)).astype(int)
    part = np.clip(at - low, 0, np.minimum(1, np.array(image.values.shape) - 1))
    total = np.zeros(len(points))
    for corner in itertools.product((0, 1), repeat=3):
        weight = np.prod(np.where(corner, part, 1 - part), axis=1)
        index = np.minimum(low + corner, np.array(image.values.shape) - 1)
        total += weight * image.values[tuple(index.T)].astype(float)
    return total


def compare_bone(bone, theirs, threshold):
    """Compares random voxels of a bone, half of them not empty, with the interpolated densities."""
    at = random_indices(bone)
    solid = np.argwhere(bone.values)
    if len(solid):
        half = rng.integers(0, len(solid), VOXELS // 2)
        at[: VOXELS // 2] = solid[half]
    points = positions(bone, at)
    expected = interpolate(theirs, points)
    found = bone.values[tuple(at.T)]
    wrong = np.where(found == 0, expected >= threshold + 1, np.abs(found - expected) > 1)
    if wrong.any():
        w = wrong.argmax()
        return f"bone: {wrong.sum()} values differ; at {points[w]}: {found[w]}, expected {expected[w]:.2f}"
    return None


def compare_resampled(bone, theirs):
    """Compares random voxels of a bone that was resampled twice by the nearest voxel."""
    solid = np.argwhere(bone.values)
    at = solid[rng.integers(0, len(solid), VOXELS)]
    points = positions(bone, at)
    for point, index, exact in zip(points, at, indices_at(theirs, points)):
        low = np.maximum(np.ceil(exact - 1.25), 0).astype(int)
        high = np.minimum(np.floor(exact + 1.25), np.array(theirs.values.shape) - 1).astype(int)
        near = theirs.values[tuple(slice(a, b + 1) for a, b in zip(low, high))]
        if not (np.rint(near.astype(float)) == bone.values[tuple(index)]).any():
            return f"no voxel near {point} has the value {bone.values[tuple(index)]}"
    return None


class Case:
    """The result of comparing one input: differences, notes, and agreements."""

    def __init__(self, path, scratch):
        self.path = path
        self.files = [os.path.join(scratch, name) for name in ("out.nrrd", "out.nii.gz")]
        self.bone = os.path.join(scratch, "bone.nrrd")
        self.theirs, unread = readers.read_all(path)
        if os.path.basename(path).startswith("pydicom-"):
            self.theirs.pop("SimpleITK", None)
        self.notes = [f"{name} does not read it: {why}" for name, why in sorted(unread.items())]
        self.differences, self.refusal, self.furthest, self.resampled = [], None, 0.0, False

    def differs(self, label, why):
        if why:
            self.differences.append(f"{label}: {why}")

    def run(self):
        self.refusal = osteon("export", self.path, "--out", self.files[0])
        if self.refusal and "--resample-oblique" in self.refusal:
            self.run_oblique()
        elif not self.refusal:
            self.run_exports()
            self.run_import()
        elif self.refusal.startswith("exit status"):
            self.differs("export", self.refusal)

    def run_oblique(self):
        self.refusal = osteon("import", self.path, "--resample-oblique", "--resample", "nearest", "--threshold", "1",
                              "--out", self.bone)
        self.resampled = not self.refusal
        for name, image in self.theirs.items() if self.resampled else ():
            self.differs(f"resampled, input by {name}", compare_resampled(readers.read_plain(self.bone), image))

    def run_exports(self):
        self.differs("NIfTI", osteon("export", self.path, "--out", self.files[1]))
        for file in self.files:
            ours, unread = readers.read_all(file)
            name = os.path.basename(file)
            for reader, why in unread.items():
                self.differs(f"{name} by {reader}", why)
            for (a, x), (b, y) in itertools.product(ours.items(), self.theirs.items()):
                why, distance = compare(x, y)
                self.differs(f"{name} by {a}, input by {b}", why)
                self.furthest = max(self.furthest, distance)

    def run_import(self):
        threshold = 120
        why = osteon("import", self.path, "--threshold", str(threshold), "--resample", "linear", "--out", self.bone)
        self.differs("import", why)
        for name, image in self.theirs.items() if not why else ():
            self.differs(f"import, input by {name}",
                         compare_bone(readers.read_plain(self.bone), image, threshold))

    def lines(self):
        if self.refusal and not self.differences:
            result = f"refused: {self.refusal}"
        elif self.differences:
            result = "DIFFERS"
        elif not self.theirs:
            result = "no reader reads it"
        else:
            how = ", resampled" if self.resampled else f"; centres at most {self.furthest:.2g} mm apart"
            result = f"equal to {', '.join(sorted(self.theirs))}{how}"
        return [result] + self.differences + self.notes


def check_sensitivity():
    """Checks that the comparisons report a changed value, a shift by half a voxel, and a reversed axis."""
    image = readers.Image(phantom_values((9, 8, 7), 200, 3000, "int16"), np.eye(4))
    shifted = readers.affine_of(np.eye(3), [1, 1, 1], [0.5, 0, 0])
    for changed in (readers.Image(image.values + 2, image.affine), readers.Image(image.values, shifted),
                    readers.Image(image.values[:, ::-1], image.affine)):
        if not compare(changed, image)[0] or not compare_bone(changed, image, 120):
            raise AssertionError("a comparison reports no difference for a changed volume")
    if compare(image, image)[0] or compare_bone(image, image, 120):
        raise AssertionError("a comparison reports a difference for equal volumes")


# ------------------------------------------------------------------ generated inputs


def phantom_values(shape, lo, hi, dtype):
    return np.asarray(rng.integers(lo, hi, shape, endpoint=True), dtype=dtype)


def generate_simpleitk(folder):
    """Writes volumes of every kind with their axes permuted and reversed."""
    import SimpleITK
    turns = [(p, s) for p in itertools.permutations(range(3)) for s in itertools.product((1, -1), repeat=3)]
    for number, suffix in enumerate((".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz") * 4):
        order, signs = turns[rng.integers(len(turns))]
        dtype = ("int16", "uint8", "uint16", "float32")[number % 4]
        image = SimpleITK.GetImageFromArray(phantom_values((7, 6, 5), 0 if dtype[0] == "u" else -900,
                                                           255 if dtype == "uint8" else 3000, dtype))
        directions = np.zeros((3, 3))
        for column, (row, sign) in enumerate(zip(order, signs)):
            directions[row, column] = sign
        image.SetDirection(directions.flatten().tolist())
        image.SetSpacing([0.5, 0.75, 1.25])
        image.SetOrigin([-12.5, 30.25, -100])
        SimpleITK.WriteImage(image, os.path.join(folder, f"simpleitk-{number}{suffix}"), useCompression=number % 3 == 0)


def generate_nibabel(folder):
    """Writes NIfTI files with a slope and an intercept, and with a slightly rotated grid."""
    import nibabel
    turns = ([1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, -1, 1, 0, 0, 0, 1, 0], [1, 1e-5, 0, -1e-5, 1, 0, 0, 0, 1])
    for number, turn in enumerate(turns):
        affine = affine_ras(turn)
        image = nibabel.Nifti1Image(phantom_values((6, 5, 7), -500, 1500, "int16"), affine)
        image.header.set_slope_inter(0.5 if number == 1 else 1, -20 if number == 1 else 0)
        nibabel.save(image, os.path.join(folder, f"nibabel-{number}.nii.gz"))


def affine_ras(turn):
    affine = readers.affine_of(turn, [0.5, 0.5, 1.5], [10, -20, 30])
    return np.diag([-1, -1, 1, 1]) @ affine


DICOM = ("", "syntax=implicit", "syntax=big", "syntax=deflated", "syntax=rle", "syntax=jpeg", "syntax=jpeg-sv1",
         "syntax=jpeg-ls", "syntax=jpeg2000", "signed=1 values=-1000,3000 intercept=0", "bits=16 values=0,33000",
         "bits=8 allocated=8 values=0,255", "slope=1,2", "rows=0,1,0 columns=0,0,-1 spacing=0.5,0.75,1.25",
         "rows=-1,0,0 columns=0,-1,0 spacing=0.7,0.5,2")
# SimpleITK truncates densities that are not integers, and leaves the frames of a file in the order of the file.
PYDICOM_ONLY = ("slope=1,2,0.5", "multiframe=1", "multiframe=1 syntax=jpeg2000 spacing=0.5,0.75,2")


def generate_dicom(folder):
    for number, words in enumerate(DICOM + PYDICOM_ONLY):
        series = os.path.join(folder, f"{'dicom' if words in DICOM else 'pydicom'}-{number}")
        os.mkdir(series)
        subprocess.run([MAKE_SERIES, series, *words.split()], check=True, stdout=subprocess.DEVNULL)


def generate(folder):
    if "SimpleITK" in readers.READERS:
        generate_simpleitk(folder)
    if "nibabel" in readers.READERS:
        generate_nibabel(folder)
    if os.access(MAKE_SERIES, os.X_OK):
        generate_dicom(folder)


def find_inputs(folder):
    """Returns the volumes below a folder: files of supported types, and folders that directly contain DICOM files."""
    found = []
    for path, folders, names in os.walk(folder):
        folders.sort()
        if any(os.path.dirname(f) == path for f in readers.dicom_files(path)):
            found.append(path)
        found += [os.path.join(path, n) for n in sorted(names) if readers.kind_of(n)]
    return found


def main():
    if len(readers.READERS) == 1:
        print("skipped: none of SimpleITK, pydicom and nibabel is installed")
        return SKIP
    if not os.access(OSTEON, os.X_OK):
        print(f"skipped: {OSTEON} does not exist")
        return SKIP
    check_sensitivity()
    print(f"readers: {', '.join(sorted(readers.READERS))}; seed {SEED}")
    inputs = [(p, p) for argument in sys.argv[1:]
              for p in (find_inputs(argument) if os.path.isdir(argument) else [argument])]
    failures = 0
    with tempfile.TemporaryDirectory() as scratch, tempfile.TemporaryDirectory() as folder:
        if not inputs:
            generate(folder)
            inputs = [(p, os.path.relpath(p, folder)) for p in find_inputs(folder)]
            data = os.environ.get("INTEROP_DATA")
            inputs += [(p, os.path.relpath(p, data)) for p in find_inputs(data)] if data else []
        for path, shown in inputs:
            case = Case(path, scratch)
            case.run()
            print(f"{shown}: " + "\n    ".join(case.lines()), flush=True)
            failures += bool(case.differences)
    print(f"{len(inputs)} inputs, {failures} differ")
    return 1 if failures else 0


sys.exit(main())
