#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the built command on small generated inputs and compares every grid, count and digest with
those of the oracle.

    CT text ---osteon import-----> BONE.nrrd, stages   |  all bit-identical to the results
    STL -------osteon voxelize---> TOOL.nrrd           |  of docs/spec/arithmetic.md alone
    path CSV --osteon ream-------> BONE2.nrrd, report  |  (osteon_oracle*.py)

The file has more than 500 lines, because each stage takes the bones and tools of the stages before it.

Covers: AR-LEN-2, AR-LEN-3, AR-LEN-4, AR-LEN-5, AR-GRID-2, AR-GRID-5, AR-POSE-2, AR-POSE-5, AR-POSE-6, AR-PATH-1, AR-PATH-2, AR-PATH-3,
AR-PATH-4, AR-PATH-5, AR-PATH-6, AR-PATH-7, AR-CT-1, AR-CT-2, AR-CT-3, AR-CT-4,
AR-CT-5, AR-CT-6, AR-CT-7, AR-CT-8, AR-CUB-1, AR-CUB-2, AR-CUB-3, AR-CUB-4, AR-CUB-5, AR-CHK-1,
AR-CHK-2, AR-CHK-3, AR-CHK-4, AR-MESH-2, AR-MESH-3,
AR-MESH-4, AR-MESH-5, AR-TOOL-2, AR-TOOL-3, AR-TOOL-4, AR-VOX-1, AR-VOX-2, AR-VOX-3, AR-VOX-4, AR-VOX-5, AR-VOX-6, AR-VOX-7,
AR-MOTOR-1, AR-MOTOR-2, AR-MOTOR-3, AR-MOTOR-4, AR-MOTOR-5, AR-MOTOR-7,
AR-SWEEP-1, AR-SWEEP-2, AR-SWEEP-4, AR-SWEEP-5, AR-SWEEP-6, AR-MAP-1, AR-MAP-3, AR-MAP-4, AR-REM-1, AR-REM-2, AR-REM-6,
AR-REM-7, AR-REM-8, AR-CLS-1, AR-CLS-2, AR-DIG-2, AR-DIG-3, AR-DIG-4, AR-DIG-5, AR-DIG-6, AR-DIG-7, AR-DIG-8, AR-FILE-1,
AR-FILE-2, AR-FILE-3, AR-LAW-4, AR-LAW-7, AR-LAW-8, REQ-ORACLE

Usage: check_pipeline.py [OSTEON]    (default: $OSTEON, else ./osteon)
OST_TEST_SEED=N replays a run. OST_TEST_BACKENDS="ref cpu:isa=avx2" selects the backends (tests/backends.h). Every
command runs on each backend, and all must print the same object, which contains the file's digest. The first path is
reamed with each chunk size, and each other path with one of the sizes in turn; OST_TEST_LONG=1 reams all with each. The
exit status is 77 if there is no command to run.
"""

import gzip
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
from fractions import Fraction

sys.dont_write_bytecode = True
import osteon_oracle as oracle
import osteon_oracle_events as events
import osteon_oracle_files as files
import osteon_oracle_tool as tools
import random_cases

SKIP = 77
BACKENDS = (os.environ.get("OST_TEST_BACKENDS") or "ref cpu:threads=2 cpu:isa=scalar,threads=3").split()
TIMES = ("time_ms", "run_ms", "tick_us")
MM = 10**9
CHUNKS = (16, 32, 64)
LONG = os.environ.get("OST_TEST_LONG") == "1"


class Different(Exception):
    pass


def equal(what, command, expected):
    if command != expected:
        raise Different(f"{what}: osteon has {str(command)[:300]}, the oracle {str(expected)[:300]}")


class Runner:
    """Runs the built command in a scratch folder."""

    def __init__(self, program, folder, rng):
        self.program, self.folder, self.rng, self.reams = program, folder, rng, 0

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="ascii", newline="") as file:
            file.write(text)
        return self.path(name)

    def run(self, *arguments):
        """Returns the JSON object that a verb prints. It must be the same on every backend except for times.
        Status 3 means that a library is missing."""
        objects = []
        for backend in BACKENDS:
            done = subprocess.run([self.program, *arguments, "--backend", backend, "--json"], capture_output=True, check=False)
            words = f"{' '.join(arguments)} --backend {backend}"
            if done.returncode == 3 and "instruction set" not in done.stderr.decode():
                raise NotHere(done.stderr.decode().strip())
            if done.returncode != 0:
                raise Different(f"{words}: status {done.returncode}: {done.stderr.decode().strip()}")
            objects.append(without_times(json.loads(done.stdout)))
            if objects[-1] != objects[0]:
                keys = [key for key in objects[0] if objects[0][key] != objects[-1].get(key)]
                raise Different(f"{words}: {', '.join(keys) or 'a key'} differs from backend {BACKENDS[0]}")
        return objects[0]


class NotHere(Exception):
    pass


def without_times(value):
    """Returns the parts of an object that must not differ between runs."""
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in TIMES}
    return [without_times(item) for item in value] if isinstance(value, list) else value


# ----------------------------------------------------------------- CT texts


def noisy_ellipsoid(rng, dims):
    """Returns the densities of a noisy ellipsoid: all classes occur, and some densities are inactive or negative."""
    nx, ny, nz = dims
    out = []
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                r = ((2 * i + 1 - nx) / nx) ** 2 + ((2 * j + 1 - ny) / ny) ** 2 + ((2 * k + 1 - nz) / nz) ** 2
                out.append(rng.choice((119, 120, 121, 149, 150, 649, 650, 1800, -1000)) if r < 0.9 else rng.randrange(-1024, 120))
    return out


def written(value, decimals, strip):
    """Returns a coordinate in mm (a Fraction) with this number of decimals, optionally without trailing zeros."""
    scaled = oracle.rhe(value * 10**decimals)
    text = f"{abs(scaled):0{decimals + 1}d}"
    text = f"{text[:-decimals]}.{text[-decimals:]}"
    if strip:
        text = text.rstrip("0").rstrip(".")
    return "-" + text if scaled < 0 else text


def ct_text(rng, dims, spacing, start, decimals, strip=False, shuffle=False, absent=0.0, repeated=0, separator=" ", head=""):
    """Returns a CT text of an ellipsoid. The number of decimals may be greater or smaller than the spacing requires."""
    lines = []
    voxels = iter(noisy_ellipsoid(rng, dims))
    axes = [[written(Fraction(o) + n * Fraction(s), decimals, strip) for n in range(count)]
            for o, s, count in zip(start, spacing, dims)]
    for k in range(dims[2]):
        for j in range(dims[1]):
            for i in range(dims[0]):
                density = next(voxels)
                corner = (i, j, k) in ((0, 0, 0), tuple(d - 1 for d in dims))
                if corner or rng.random() >= absent:
                    density = rng.choice((f"{density}", f"{density}.0", f"{density}0e-1")) if rng.random() < 0.1 else f"{density}"
                    lines.append(separator.join((axes[0][i], axes[1][j], axes[2][k], density)))
    lines += rng.sample(lines, repeated)
    if shuffle:
        rng.shuffle(lines)
    return head + "\n".join(lines) + "\n"


def check_import(runner, name, content, options=(), chunk=32, **how):
    """Compares osteon import with text -> rect -> cubic -> bone. Returns the oracle's bone and the file's name."""
    text = oracle.Text(content)
    rect, scatter = oracle.text_to_rect(text, how.get("spacing"), crop=how.get("crop"))
    rule = how.get("rule", "linear")
    cubic = oracle.rect_to_cubic(rect, how.get("cubic"), rule)
    bone = oracle.Bone(cubic, how.get("threshold", 120))
    source, out = runner.write(name + ".txt", content), runner.path(name + ".nrrd")
    got = runner.run("import", source, "--out", out, "--chunk", str(chunk), *options)

    equal(f"{name}: rect_dims", got["rect_dims"], list(rect.dims))
    equal(f"{name}: rect_spacing_mm", [oracle.rhe(Fraction(repr(s)) * MM) for s in got["rect_spacing_mm"]], list(rect.spacing))
    equal(f"{name}: cubic_dims", got["cubic_dims"], list(cubic.dims))
    for key, value in bone.info(chunk).items():
        equal(f"{name}: {key}", got[key], value)
    for key in ("samples", "duplicates", "off_lattice"):
        if key in got:
            equal(f"{name}: {key}", got[key], scatter[key])
    digests = {"samples": oracle.samples_digest(text), "rect": oracle.grid_digest(rect, oracle.KIND_RECT),
               "cubic": oracle.grid_digest(cubic, oracle.KIND_CUBIC), "chunks": oracle.grid_digest(bone, oracle.KIND_BONE)}
    equal(f"{name}: stages", {stage["name"]: stage.get("sha256") for stage in got["stages"]}, digests)
    equal_file(name, out, bone, {"kind": "bone", "arithmetic": "2", "threshold": str(bone.threshold), "resample": rule})
    return bone, out


def equal_file(name, path, grid, facts):
    """Compares a NRRD that osteon wrote with a grid."""
    got, meta = files.read_nrrd(path)
    equal(f"{name}: dims of the file", got.dims, grid.dims)
    equal(f"{name}: spacing of the file", got.spacing, grid.spacing)
    equal(f"{name}: origin of the file", got.origin, grid.origin)
    for key, value in facts.items():
        equal(f"{name}: osteon_{key}", meta.get(key), value)
    if got.voxels != grid.voxels:
        at = next(n for n, (a, b) in enumerate(zip(got.voxels, grid.voxels)) if a != b)
        nx, ny, _ = grid.dims
        where = (at % nx, at // nx % ny, at // nx // ny)
        raise Different(f"{name}: voxel {where}: osteon has {got.voxels[at]}, the oracle {grid.voxels[at]}")


def imports(runner):
    rng = runner.rng
    check_import(runner, "scapula-like", ct_text(rng, (23, 19, 11), ("0.47", "0.47", "1"), ("-57.34", "12.5", "-7"), 4,
                                                 head="x_mm y_mm z_mm HU\n"))
    check_import(runner, "six-decimals", ct_text(rng, (34, 9, 33), ("0.48828125",) * 3, ("-57.34", "3", "0"), 6, shuffle=True,
                                                 absent=0.3, repeated=40, separator=" , "), chunk=16)
    check_import(runner, "four-decimals", ct_text(rng, (34, 17, 12), ("0.48828125", "0.48828125", "0.625"), ("0", "0", "0"), 4,
                                                  separator=";"), chunk=64)
    check_import(runner, "no-trailing-zeros", ct_text(rng, (40, 21, 22), ("0.032",) * 3, ("-0.5", "0", "0.1"), 6, strip=True))
    check_import(runner, "tenths", ct_text(rng, (33, 12, 14), ("0.3", "0.3", "0.3"), ("0", "-57.34", "0"), 4, separator="\t"))
    check_import(runner, "given-in-text", ct_text(rng, (20, 10, 1), ("0.488281",) * 3, ("1", "1", "1"), 3,
                                                  head="# osteon spacing_mm: 0.488281 0.488281 2.5\r\n"))
    # The coordinates have one decimal, so rounding hides the origin of 0.02 mm along x. The facts in
    # the text state it.
    check_import(runner, "origin-in-text", ct_text(rng, (12, 10, 9), ("0.48828125",) * 3, ("0.02", "0", "0"), 1,
                                                   head="# osteon dims: 12 10 9\n# osteon spacing_mm: 0.48828125 0.48828125 0.48828125\n"
                                                        "# osteon origin_mm: 0.02 0 0\n"))
    check_import(runner, "given", ct_text(rng, (20, 10, 9), ("0.7", "0.9", "1.1"), ("1", "1", "1"), 1), ("--spacing", "0.7,0.9,1.1"),
                 spacing=(700000000, 900000000, 1100000000))
    check_import(runner, "coarser", ct_text(rng, (31, 14, 9), ("0.7", "0.9", "1.1"), ("1", "1", "1"), 1),
                 ("--cubic", "0.8", "--threshold", "150"), cubic=800000000, threshold=150)
    for rule in ("nearest", "thesis"):
        check_import(runner, rule, ct_text(rng, (23, 11, 9), ("0.7", "0.9", "1.1"), ("1", "1", "1"), 1),
                     ("--cubic", "0.45", "--resample", rule), cubic=450000000, rule=rule)
    # According to AR-GRID-5, a sample outside the crop may be anywhere between the layers, and may be
    # repeated with another density.
    content = ct_text(rng, (20, 12, 9), ("0.7", "0.9", "1.1"), ("1", "-2", "3"), 2, shuffle=True)
    content += "1.3 -2 3 5\n1 -2 3 31000\n"
    check_import(runner, "part", content, ("--crop", "4:17,2:11,1:7", "--spacing", "0.7,0.9,1.1"), spacing=(700000000, 900000000, 1100000000),
                 crop=((4, 2, 1), (17, 11, 7)))
    # The records of AR-DIG-6 are in the order x, y, z even if z changes fastest from line to line.
    lines = ct_text(rng, (9, 12, 14), ("0.5", "0.75", "1.25"), ("-3", "2", "7"), 2).splitlines(keepends=True)
    check_import(runner, "z-fastest", "".join(sorted(lines, key=lambda line: [Fraction(word) for word in line.split()[:3]])))
    thresholds(runner)


def thresholds(runner):
    """Checks that thresholds that select the same voxels give equal bones with different digests (AR-DIG-1)."""
    content = ct_text(runner.rng, (9, 8, 7), ("0.7",) * 3, ("0", "0", "0"), 1)
    content = "".join(line if not 119 <= float(line.split()[3]) <= 130 else line.rsplit(" ", 1)[0] + " 100\n"
                      for line in content.splitlines(keepends=True))
    bones = [check_import(runner, f"threshold-{t}", content, ("--threshold", str(t)), threshold=t)[0] for t in (120, 130)]
    equal("thresholds: voxels", bones[0].voxels == bones[1].voxels and any(bones[0].voxels), True)
    digests = [[oracle.grid_digest(bone, kind) for bone in bones] for kind in (oracle.KIND_CUBIC, oracle.KIND_BONE)]
    equal("thresholds: digests", (digests[0][0] == digests[0][1], digests[1][0] == digests[1][1]), (True, False))


# ------------------------------------------------------------------- floats


def nifti(dims, spacing, origin, densities):
    """Returns a NIfTI-1 with an sform in float32; spacing and origin are in LPS, so x and y are negated."""
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *dims, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 4, 16)
    struct.pack_into("<8f", head, 76, 1, *spacing, 0, 0, 0, 0)
    struct.pack_into("<f", head, 108, 352)
    head[123] = 2  # mm
    struct.pack_into("<2h", head, 252, 0, 1)
    for a, sign in enumerate((-1, -1, 1)):
        row = [0.0, 0.0, 0.0, sign * origin[a]]
        row[a] = sign * spacing[a]
        struct.pack_into("<4f", head, 280 + 16 * a, *row)
    head[344:348] = b"n+1\0"
    return bytes(head) + struct.pack(f"<{len(densities)}h", *densities)


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def floats(runner):
    """Compares a CT as NIfTI, whose lengths are float32, with the oracle and with the same CT as NRRD."""
    rng, dims = runner.rng, (7, 6, 5)
    for name, spacing, origin in (("shoulder", ("0.841796875", "0.841796875", "5"), ("-198.912109375", "-117.8", "-159.03")),
                                  ("seventh-digit", ("0.4882812", "0.4882813", "0.625"), ("12.3", "-0.1", "431.217"))):
        densities = noisy_ellipsoid(rng, dims)
        exact = oracle.Grid(dims, tuple(oracle.length(Fraction(s)) for s in spacing), tuple(oracle.length(Fraction(o)) for o in origin), densities)
        read = oracle.Grid(dims, tuple(oracle.length(oracle.shortest_decimal(float32(float(s)), 32)) for s in spacing),
                           tuple(oracle.length(oracle.shortest_decimal(float32(float(o)), 32)) for o in origin), densities)
        equal(f"{name}: what float32 says", (read.spacing, read.origin), (exact.spacing, exact.origin))
        with open(runner.path(name + ".nii"), "wb") as file:
            file.write(nifti(dims, [float(s) for s in spacing], [float(o) for o in origin], densities))
        with open(runner.path(name + ".nrrd"), "w", encoding="ascii") as file:
            file.write(f"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {' '.join(map(str, dims))}\n"
                       f"space directions: ({spacing[0]},0,0) (0,{spacing[1]},0) (0,0,{spacing[2]})\nencoding: text\n"
                       f"space origin: ({','.join(origin)})\n\n{' '.join(map(str, densities))}\n")
        bone = oracle.Bone(oracle.rect_to_cubic(exact, oracle.length(Fraction(spacing[0]))))
        for kind in ("nii", "nrrd"):
            out = runner.path(f"{name}-{kind}-bone.nrrd")
            runner.run("import", runner.path(f"{name}.{kind}"), "--cubic", spacing[0], "--out", out)
            equal_file(f"{name}.{kind}", out, bone, {"resample": "linear"})
    # The same grid is written with other digits of the same float32. It must be reported as
    # equal, but only to the precision of float32.
    coarse = runner.write("coarse.nrrd", open(runner.path("shoulder.nrrd"), encoding="ascii").read().replace("0.841796875", "0.8417969"))
    got = runner.run("diff", runner.path("shoulder.nii"), coarse)
    equal("two spellings of a float32", (got["equal"], got["rounded_geometry"]), (True, True))
    got = runner.run("diff", runner.path("shoulder.nii"), runner.path("shoulder.nrrd"))
    equal("one length", (got["equal"], got["rounded_geometry"]), (True, False))
    moved = runner.write("moved.nrrd", open(runner.path("shoulder.nrrd"), encoding="ascii").read().replace("-117.8", "-117.8001"))
    done = subprocess.run([runner.program, "diff", coarse, moved], capture_output=True, check=False)
    equal("an origin that is another", done.returncode, 1)


# ------------------------------------------------------------------- meshes


def tetrahedron(rng, size):
    """Returns a closed tetrahedron with outward or inward normals. Its coordinates are multiples of 1/8
    mm, so every float type represents them exactly."""
    while True:
        points = [[Fraction(rng.randrange(-size * 8, size * 8 + 1), 8) for _ in range(3)] for _ in range(4)]
        edges = [[p - q for p, q in zip(point, points[0])] for point in points[1:]]
        volume = sum(edges[0][a] * (edges[1][(a + 1) % 3] * edges[2][(a + 2) % 3] - edges[1][(a + 2) % 3] * edges[2][(a + 1) % 3])
                     for a in range(3))
        if abs(volume) > size**3:
            return points, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def box(low, high):
    corners = [[(low, high)[n >> a & 1][a] for a in range(3)] for n in range(8)]
    return corners, [(0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 2, 3), (0, 3, 1),
                     (4, 5, 7), (4, 7, 6)]


def join(*bodies):
    points, triangles = [], []
    for body_points, body_triangles in bodies:
        triangles += [tuple(v + len(points) for v in t) for t in body_triangles]
        points += body_points
    return points, triangles


def stl(mesh):
    points, triangles = mesh
    facets = []
    for triangle in triangles:
        vertices = "".join(f"vertex {float(points[v][0])} {float(points[v][1])} {float(points[v][2])}\n" for v in triangle)
        facets.append(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    return "solid generated\n" + "".join(facets) + "endsolid generated\n"


def as_read(mesh):
    """Returns the mesh as read from an STL: three vertices per triangle, in picometres, with equal vertices merged."""
    points, triangles = mesh
    corners = [tuple(tools.vertex_pm(float(c)) for c in points[v]) for triangle in triangles for v in triangle]
    return tools.weld(corners, [(n, n + 1, n + 2) for n in range(0, len(corners), 3)])


def check_voxelize(runner, name, mesh, voxel, rule="winding", noncutting=None):
    """Compares osteon voxelize with the oracle. Returns the oracle's tool and the file's name."""
    tool = tools.Tool(as_read(mesh), oracle.length(Fraction(voxel)), as_read(noncutting) if noncutting else None, rule)
    out = runner.path(name + ".nrrd")
    options = ["--voxel", voxel, "--rule", rule]
    if noncutting:
        options += ["--noncutting", runner.write(name + "-shaft.stl", stl(noncutting))]
    got = runner.run("voxelize", runner.write(name + ".stl", stl(mesh)), "--out", out, *options)
    equal(f"{name}: dims", got["dims"], list(tool.dims))
    equal(f"{name}: solid_voxels", got["solid_voxels"], sum(1 for v in tool.voxels if v))
    equal(f"{name}: dropped_triangles", got["dropped_triangles"], tool.dropped)
    equal(f"{name}: leaking_rows", got["leaking_rows"], tool.leaking_rows)
    if "mesh_sha256" in got:
        equal(f"{name}: mesh_sha256", got["mesh_sha256"], tool.snapped[0].digest())
    equal_file(name, out, tool, {"kind": "tool", "arithmetic": "2"})
    equal(f"{name}: sha256", got["sha256"], tool.digest())
    return tool, out


def meshes(runner):
    rng = runner.rng
    for n, voxel in enumerate(("0.5", "0.37", "0.25")):
        check_voxelize(runner, f"tetrahedron-{n}", tetrahedron(rng, 3), voxel)
    several = join(*(tetrahedron(rng, 3) for _ in range(3)))
    for rule in ("winding", "parity"):
        check_voxelize(runner, f"crossing-{rule}", several, "0.5", rule)
    # All faces and edges of these two bodies lie on voxel centres, and one body is inside the other.
    quarter = Fraction(1, 4)
    on_centres = join(box([quarter] * 3, [4 + quarter] * 3), box([1 + quarter] * 3, [2 + quarter] * 3))
    for rule in ("winding", "parity"):
        check_voxelize(runner, f"on-centres-{rule}", on_centres, "0.5", rule)
    points, triangles = box([Fraction(-2)] * 3, [Fraction(2)] * 3)
    check_voxelize(runner, "leaking", (points, triangles[1:]), "0.5")
    # A tetrahedron of 600 mm by 1/128 mm by 1/128 mm is dropped when the mesh is snapped, because a
    # unit of the lattice is 60/1024 mm.
    sliver = [[Fraction(0)] * 3, [Fraction(600)] + [Fraction(0)] * 2, [Fraction(0), Fraction(1, 128), Fraction(0)], [Fraction(0)] * 2 + [Fraction(1, 128)]]
    check_voxelize(runner, "sliver", join((sliver, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]), box([Fraction(0)] * 3, [Fraction(600)] * 3)),
                   "60")


def solid_set(runner, name, mesh, voxel):
    """Returns the centres of the solid voxels in world coordinates, in picometres."""
    out = runner.path(name + ".nrrd")
    got = runner.run("voxelize", runner.write(name + ".stl", stl(mesh)), "--voxel", voxel, "--out", out)
    equal(f"{name}: leaking_rows", got["leaking_rows"], 0)
    tool, _ = files.read_nrrd(out)
    nx, ny, _ = tool.dims
    return {tuple(o + (2 * i + 1) * s // 2 for o, s, i in zip(tool.origin, tool.spacing, (n % nx, n // nx % ny, n // nx // ny)))
            for n, v in enumerate(tool.voxels) if v}


def laws(runner):
    """Tests AR-LAW-4, AR-LAW-7 and AR-LAW-8 on the command alone, so that a mistake that the oracle shares is detected."""
    points, triangles = tetrahedron(runner.rng, 3)
    whole = solid_set(runner, "law", (points, triangles), "0.5")
    equal("AR-LAW-8: faces reversed", solid_set(runner, "reversed", (points, [(a, c, b) for a, b, c in triangles]), "0.5"), whole)
    shift = (Fraction(3, 2), Fraction(-1), Fraction(1, 2))
    moved = [[c + d for c, d in zip(point, shift)] for point in points]
    equal("AR-LAW-4: a mesh moved by whole voxels", solid_set(runner, "moved", (moved, triangles), "0.5"),
          {tuple(c + int(d * MM) for c, d in zip(centre, shift)) for centre in whole})
    # A box is cut at x = 1/8, where there are no voxel centres (they are at odd quarters). The
    # union of the halves must be the box.
    low, high, cut = [Fraction(-2)] * 3, [Fraction(2)] * 3, Fraction(1, 8)
    halves = solid_set(runner, "left", box(low, [cut, *high[1:]]), "0.5") | solid_set(runner, "right", box([cut, *low[1:]], high), "0.5")
    equal("AR-LAW-7: two halves", halves, solid_set(runner, "box", box(low, high), "0.5"))


# -------------------------------------------------------------------- reams


def decimal_of(value, places):
    scaled = oracle.rhe(value * 10**places)
    return f"{'-' if scaled < 0 else ''}{abs(scaled) // 10**places}.{abs(scaled) % 10**places:0{places}d}"


def turned(rng, any_turn):
    """Returns a quaternion with nine decimals: within 12 degrees of the identity, or, if any_turn, a
    much larger rotation, sometimes a quarter turn or half a turn."""
    if any_turn and rng.random() < 0.3:
        return rng.choice((("0.707106781", "0", "0", "0.707106781"), ("0", "1", "0", "0"), ("0.5", "-0.5", "0.5", "0.5")))
    spread = 0.55 if any_turn else 0.06
    v = [rng.uniform(-spread, spread) for _ in range(3)]
    w = (1 - sum(c * c for c in v)) ** 0.5
    return tuple(f"{c:.9f}" for c in (w, *v))


def path(rng, bone, ticks, step_mm, tool_count, any_turn, every_ms=1):
    """Returns a path through the bone's centre. Some steps are multiples of a voxel, so that poses lie
    exactly on borders."""
    at = [Fraction(o + s * n // 2, MM) for o, s, n in zip(bone.origin, bone.spacing, bone.dims)]
    rows, tool = ["t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool"], 0
    for tick in range(ticks):
        if tick:
            on_voxels = rng.random() < 0.3
            at = [c + (rng.randrange(-1, 2) * Fraction(bone.spacing[0], MM) if on_voxels
                       else Fraction(rng.randrange(-1000, 1001), 1000) * step_mm) for c in at]
        tool = rng.randrange(tool_count) if rng.random() < 0.3 else tool
        q = turned(rng, any_turn)
        sign = rng.choice((1, -1))
        q = tuple(c if sign > 0 else c[1:] if c.startswith("-") else "-" + c for c in q)
        rows.append(",".join((decimal_of(Fraction(tick * every_ms, 1000), 6), *(decimal_of(c, 9) for c in at), *q, str(tool))))
    return "\n".join(rows) + "\n"


def tracked_path(rng, bone, rows, metres):
    """Returns the rows of a simulated tracker, one every 3.5 ms, and one every 40 ms in the second half.
    Some rows have no pose, and there are additional columns. If metres is false, some rows are omitted,
    and there is a jump."""
    unit, places = ("m", 12) if metres else ("mm", 9)
    at = [Fraction(o + s * n // 2, MM) for o, s, n in zip(bone.origin, bone.spacing, bone.dims)]
    text, missing = [f"t_s,x_{unit},y_{unit},z_{unit},qw,qx,qy,qz,movement,tool" + (",lifted" if metres else "")], rng.randrange(3, rows)
    for row in range(rows):
        at = [c + Fraction(rng.randrange(-400, 401), 1000) for c in at]
        if row == missing and not metres:
            at[0] += 6 * rng.choice((1, -1))
        if rng.random() < 0.15 and not metres:
            continue
        pose = [decimal_of(c / (1000 if metres else 1), places) for c in at] + list(turned(rng, False))
        if rng.random() < 0.2:
            pose[rng.randrange(7)] = rng.choice(("nan", "NaN"))
        text.append(",".join([decimal_of(Fraction(row * (35 if row < rows // 2 else 400), 10000), 6), *pose, "a", rng.choice(("0", "+0", "0.0"))]
                             + [str(int(rng.random() < 0.3))] * metres))
    return "\n".join(text) + "\n"


def check_ream(runner, name, bone, bone_file, shapes, ticks, options=(), contents=None, max_gap=None, rate=None, rpm=200, every_ms=1, **how):
    """Compares osteon ream with the oracle, which works on a copy of the bone."""
    left = oracle.Bone(bone, bone.threshold)
    if rate:
        how["period_ns"], options = events.period(rate), (*options, "--rate", rate)
    session = events.Session(left, [tool for tool, _ in shapes], **how)
    contents = contents or [path(runner.rng, bone, ticks, Fraction(6, 10), len(shapes), not session.sweep, every_ms)]
    paths, arguments = [events.read_path(content, max_gap) for content in contents], ["ream", "--bone", bone_file]
    gaps = sum(row.lifted for part in paths for row in part)
    motor, options = events.Motor(), ("--rpm", str(rpm), *options)
    for row in events.ticks_of_rows(events.join(paths, len(shapes)), rpm):
        session.tick(row.t_ns, motor.turn(row.t_ns, row.pose, rpm), row.tool, row.lifted, rpm)
    for k, content in enumerate(contents):
        packed = content.startswith("t_s,x_m,")
        file = runner.write(f"{name}-{k}.csv", content)
        if packed:
            with open(file, "rb") as plain, gzip.open(file + ".gz", "wb") as out:
                out.write(plain.read())
        arguments += ["--path", file + ".gz" * packed]
    for _, tool_file in shapes:
        arguments += ["--tool", tool_file]
    expected = oracle.grid_digest(left, oracle.KIND_BONE)
    whole = None
    for chunk in CHUNKS if LONG or not runner.reams else (CHUNKS[runner.reams % len(CHUNKS)],):
        out = runner.path(f"{name}-{chunk}.nrrd")
        got = runner.run(*arguments, "--out", out, "--chunk", str(chunk), *options)
        for key in ("ticks", "removals", "poses"):
            if key in got:
                equal(f"{name}: {key}", got[key], getattr(session, key))
        equal(f"{name}: gaps", got["gaps"], gaps)
        equal(f"{name}: removed_voxels", got["removed_voxels"], session.removed)
        volume = float(Fraction(session.removed * bone.spacing[0] ** 3, MM**3))  # AR-REM-8
        equal(f"{name}: removed_mm3", abs(got["removed_mm3"] - volume) <= 1e-9 * volume, True)
        equal(f"{name}: removed_by_class", [(row["voxels"], row["density_sum"]) for row in got["removed_by_class"]],
              list(zip(session.by_class, session.density_by_class)))
        equal_file(name, out, left, {"kind": "bone", "threshold": str(bone.threshold)})
        equal(f"{name}: sha256", got["sha256"], expected)
        with open(out, "rb") as file:
            content = file.read()
        equal(f"{name}: bytes of the file whatever the chunks", whole in (None, content), True)
        whole = content
    runner.reams += 1
    if session.removed == 0:
        raise Different(f"{name}: no voxel was removed, so the case tests nothing")


def check_motor_off(runner, bone, bone_file, tool_file):
    """Checks that a path through the bone's centre removes nothing with --rpm 0 (AR-MOTOR-5)."""
    content = path(runner.rng, bone, 20, Fraction(6, 10), 1, True)
    got = runner.run("ream", "--bone", bone_file, "--tool", tool_file, "--path", runner.write("off.csv", content), "--rpm", "0",
                     "--out", runner.path("off.nrrd"))
    equal("--rpm 0", (got["ticks"], got["removals"], got["removed_voxels"]), (20, 0, 0))


def reams(runner):
    rng = runner.rng
    bone, bone_file = check_import(runner, "bone", ct_text(rng, (31, 28, 14), ("0.47", "0.47", "1"), ("-57.34", "12.5", "-7"), 4))
    first = check_voxelize(runner, "tool", join(tetrahedron(rng, 4), tetrahedron(rng, 3)), "0.5")
    ball = box([Fraction(-3, 2)] * 3, [Fraction(3, 2)] * 3)
    shaft = box([Fraction(-1, 2), Fraction(-1, 2), Fraction(0)], [Fraction(1, 2), Fraction(1, 2), Fraction(6)])
    second = check_voxelize(runner, "shafted", ball, "0.47", noncutting=shaft)
    check_ream(runner, "swept", bone, bone_file, [first], 5)
    check_ream(runner, "thesis", bone, bone_file, [second], 8, ("--sweep", "off"), sweep=False)
    check_ream(runner, "two-tools", bone, bone_file, [first, second], 6)
    check_ream(runner, "rated", bone, bone_file, [second], 9, rate=rng.choice(("400", "333.3", "1e2")))
    tracked = [tracked_path(rng, bone, 12, metres) for metres in (False, True)]
    check_ream(runner, "tracked", bone, bone_file, [second], 0, contents=tracked)
    check_ream(runner, "tracked-two", bone, bone_file, [first, second], 0, contents=tracked, rate="250")
    check_ream(runner, "tracked-off", bone, bone_file, [second], 0, ("--max-gap", "off"), contents=tracked, max_gap=(None, None))
    check_ream(runner, "tracked-given", bone, bone_file, [second], 0, ("--max-gap", "5,0.3"), contents=tracked, max_gap=(5 * 10**6, 3 * 10**8))
    check_ream(runner, "coarse", bone, bone_file, [second], 2, rpm=rng.randrange(190, 240), every_ms=45)
    check_ream(runner, "fast", bone, bone_file, [second], 6, rpm=3000)
    check_motor_off(runner, bone, bone_file, second[1])


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("OSTEON", "./osteon")
    for module in (oracle, tools, events):
        module.self_check()
    if not os.access(program, os.X_OK):
        print(f"# {program} is not built: only the oracle's own numbers were checked")
        return SKIP
    seed = random_cases.seeded("check_pipeline")
    status = 0
    with tempfile.TemporaryDirectory() as folder:
        for part in (imports, floats, meshes, laws, reams):
            start = time.monotonic()
            try:
                part(Runner(os.path.abspath(program), folder, random.Random(seed)))
                print(f"ok {part.__name__} ({time.monotonic() - start:.1f} s)", flush=True)
            except NotHere as reason:
                print(f"# {part.__name__} skipped: {reason}")
                status = status or SKIP
            except (Different, oracle.Refused) as difference:
                print(f"not ok {part.__name__}: {difference}", flush=True)
                status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
