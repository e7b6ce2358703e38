# SPDX-License-Identifier: Apache-2.0
"""Independent readers of volumes. Each returns an Image: values by voxel index (i, j, k), and the affine that gives
the position of a voxel's centre in LPS millimetres. A reader whose package is not installed is not in READERS.

    name        package     reads
    SimpleITK   SimpleITK   .nrrd .nhdr .nii .nii.gz .hdr .mha .mhd, folders with DICOM files
    nibabel     nibabel     .nii .nii.gz .hdr
    pydicom     pydicom     folders with DICOM files
    plain       (numpy)     .nrrd .nhdr, by the function in this file, so that a comparison needs only one package
"""

import gzip
import os

import numpy as np


class Image:
    """A volume; `values` may have any type of numbers."""

    def __init__(self, values, affine):
        self.values = values
        self.affine = np.asarray(affine, dtype=float)


class Unreadable(Exception):
    """Raised if a reader does not support a file."""


def dicom_files(folder):
    """Returns the files below a folder that begin like DICOM files."""
    found = []
    for path, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(path, name), "rb") as file:
                if file.read(132)[128:] == b"DICM":
                    found.append(os.path.join(path, name))
    return sorted(found)


def affine_of(directions, spacing, origin):
    affine = np.eye(4)
    affine[:3, :3] = np.asarray(directions, dtype=float).reshape(3, 3) * np.asarray(spacing, dtype=float)
    affine[:3, 3] = origin
    return affine


NRRD_TYPES = {"short": "i2", "int16": "i2", "uchar": "u1", "unsigned char": "u1", "uint8": "u1", "ushort": "u2",
              "unsigned short": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "float": "f4", "double": "f8"}
NRRD_SPACES = {"left-posterior-superior": (1, 1, 1), "LPS": (1, 1, 1), "right-anterior-superior": (-1, -1, 1),
               "RAS": (-1, -1, 1), "left-anterior-superior": (1, -1, 1), "LAS": (1, -1, 1)}


def nrrd_data(path, text):
    """Returns the bytes of a detached header's data: one file, or files numbered by FORMAT MIN MAX STEP."""
    words = text.split()
    names = [text]
    if len(words) == 4 and "%" in words[0]:
        first, last, step = (int(w) for w in words[1:])
        names = [words[0] % n for n in range(first, last + 1, step)]
    data = b""
    for name in names:
        with open(os.path.join(os.path.dirname(path), name), "rb") as file:
            data += file.read()
    return data


def read_plain(path):
    """Reads an NRRD, raw or gzip. If the space does not name the patient's axes, LPS is assumed."""
    with open(path, "rb") as file:
        head, _, data = file.read().partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in head.decode().split("\n")[1:] if ": " in line)
    data = nrrd_data(path, fields["data file"]) if "data file" in fields else data
    if fields["encoding"] in ("gzip", "gz"):
        data = gzip.decompress(data)
    sizes = [int(n) for n in fields["sizes"].split()]
    values = np.frombuffer(data, dtype=(">" if fields.get("endian") == "big" else "<") + NRRD_TYPES[fields["type"]],
                           count=int(np.prod(sizes))).reshape(sizes, order="F")
    if "space directions" in fields:
        columns = np.array([[float(v) for v in text.strip("()").split(",")]
                            for text in fields["space directions"].split()]).T
        origin = [float(v) for v in fields["space origin"].strip("()").split(",")]
    else:
        columns, origin = np.diag([float(v) for v in fields["spacings"].split()]), [0, 0, 0]
    signs = NRRD_SPACES.get(fields.get("space"), (1, 1, 1))
    return Image(values, np.diag([*signs, 1]) @ affine_of(columns, [1, 1, 1], origin))


READERS = {"plain": (read_plain, (".nrrd", ".nhdr"))}

try:
    import SimpleITK

    def read_simpleitk(path):
        if os.path.isdir(path):
            folders = sorted({os.path.dirname(f) for f in dicom_files(path)})
            reader = SimpleITK.ImageSeriesReader()
            series = [(f, uid) for f in folders for uid in reader.GetGDCMSeriesIDs(f)]
            if len(series) != 1:
                raise Unreadable(f"{len(series)} DICOM series, expected 1")
            reader.SetFileNames(reader.GetGDCMSeriesFileNames(*series[0]))
            image = reader.Execute()
        else:
            image = SimpleITK.ReadImage(path)
        if image.GetDimension() == 4 and image.GetSize()[3] == 1:
            image = image[:, :, :, 0]
        if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
            raise Unreadable("not a volume with one value per voxel")
        values = SimpleITK.GetArrayFromImage(image).transpose(2, 1, 0)
        return Image(values, affine_of(image.GetDirection(), image.GetSpacing(), image.GetOrigin()))

    SimpleITK.ProcessObject.SetGlobalWarningDisplay(False)
    READERS["SimpleITK"] = (read_simpleitk, (".nrrd", ".nhdr", ".nii", ".nii.gz", ".hdr", ".mha", ".mhd", "dicom"))
except ImportError:
    pass

try:
    import nibabel

    def read_nibabel(path):
        image = nibabel.load(path)
        values = np.asanyarray(image.dataobj)
        if values.ndim == 4 and values.shape[3] == 1:
            values = values[..., 0]
        if values.ndim != 3:
            raise Unreadable("not a volume")
        return Image(values, np.diag([-1, -1, 1, 1]) @ image.affine)  # NIfTI is RAS

    READERS["nibabel"] = (read_nibabel, (".nii", ".nii.gz", ".hdr"))
except ImportError:
    pass

try:
    import pydicom

    def frames_of(file):
        """Yields (position, orientation, spacing, pixels as densities) of each frame of a file."""
        pixels = file.pixel_array
        many = int(file.get("NumberOfFrames", 1))
        for f in range(many):
            shared = file.SharedFunctionalGroupsSequence[0] if "SharedFunctionalGroupsSequence" in file else file
            own = file.PerFrameFunctionalGroupsSequence[f] if "PerFrameFunctionalGroupsSequence" in file else file

            def group(sequence, shared=shared, own=own):
                where = own if sequence in own else shared
                return where[sequence][0] if sequence in where else file

            rescale = group("PixelValueTransformationSequence")
            values = (pixels[f] if pixels.ndim == 3 else pixels) * float(rescale.get("RescaleSlope", 1)) + float(
                rescale.get("RescaleIntercept", 0))
            yield ([float(v) for v in group("PlanePositionSequence").ImagePositionPatient],
                   [float(v) for v in group("PlaneOrientationSequence").ImageOrientationPatient],
                   [float(v) for v in group("PixelMeasuresSequence").PixelSpacing], values)

    def read_pydicom(path):
        frames = [frame for name in dicom_files(path) for frame in frames_of(pydicom.dcmread(name))]
        orientation, spacing = frames[0][1], frames[0][2]
        if any(f[1] != orientation or f[2] != spacing or f[3].shape != frames[0][3].shape for f in frames):
            raise Unreadable("frames of several geometries")
        rows, columns = np.array(orientation[:3]), np.array(orientation[3:])
        normal = np.cross(rows, columns)
        frames.sort(key=lambda f: float(np.dot(f[0], normal)))
        step = (np.array(frames[-1][0]) - frames[0][0]) / max(len(frames) - 1, 1)
        affine = np.eye(4)
        affine[:3, 0], affine[:3, 1], affine[:3, 2] = rows * spacing[1], columns * spacing[0], step
        affine[:3, 3] = frames[0][0]
        return Image(np.stack([f[3].T for f in frames], axis=2), affine)

    READERS["pydicom"] = (read_pydicom, ("dicom",))
except ImportError:
    pass


def kind_of(path):
    """Returns the suffix that selects the readers of a file, "dicom" for a folder with DICOM files, or None."""
    if os.path.isdir(path):
        return "dicom" if dicom_files(path) else None
    for suffix in (".nii.gz", ".nii", ".hdr", ".nrrd", ".nhdr", ".mha", ".mhd"):
        if path.endswith(suffix):
            return suffix
    return None


def read_all(path):
    """Returns {name of a reader: Image} and {name of a reader: reason for a failure} for the readers of this type of file."""
    kind, images, refused = kind_of(path), {}, {}
    for name, (read, kinds) in READERS.items():
        if kind not in kinds:
            continue
        try:
            images[name] = read(path)
        except Exception as why:  # pylint: disable=broad-except  # another program's errors have any type
            refused[name] = str(why).strip().split("\n")[-1]
    return images, refused
