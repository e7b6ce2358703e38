# SPDX-License-Identifier: Apache-2.0
"""Implements mesh -> snapped mesh -> tool grid as defined in docs/spec/arithmetic.md, sections 9 and 10.

The crossing of a row with a triangle's plane is computed as a fraction and
compared with voxel centres, whereas the C code evaluates a determinant. The
self-check compares the ownership rule with the limit that the rule represents: a
point that is moved by (e, e^2) for small e.
"""

import hashlib
import struct
from fractions import Fraction

from osteon_oracle import ARITHMETIC_VERSION, KIND_TOOL, LENGTH_MAX, Grid, Refused, ceil, grid_digest, rhe

UNIT_PM = {"um": 10**6, "mm": 10**9, "cm": 10**10, "m": 10**12, "inch": 25400000000}


def vertex_pm(value, unit="mm"):
    """Converts a coordinate to picometres according to AR-MESH-2. The value is a binary float and is converted exactly."""
    pm = rhe(Fraction(value) * UNIT_PM[unit])
    if abs(pm) > LENGTH_MAX:
        raise Refused("a vertex beyond 8 m")
    return pm


def weld(vertices, triangles):
    """Merges equal vertices according to AR-MESH-5."""
    number = {}
    renumbered = [number.setdefault(vertex, len(number)) for vertex in vertices]
    return list(number), [tuple(renumbered[v] for v in triangle) for triangle in triangles]


class ToolGeometry:
    """A tool's grid as defined by AR-TOOL-1 and AR-TOOL-2."""

    def __init__(self, meshes, voxel):
        used = [vertices[v] for vertices, triangles in meshes for triangle in triangles for v in triangle]
        self.voxel = voxel
        low, high = [[end(p[a] for p in used) for a in range(3)] for end in (min, max)]
        self.corner = tuple(rhe(Fraction(2 * l - voxel, 2 * voxel)) * voxel - voxel for l in low)
        far = [rhe(Fraction(2 * h + voxel, 2 * voxel)) * voxel + voxel for h in high]
        self.dims = tuple((f - c) // voxel for f, c in zip(far, self.corner))
        if not 10**6 <= voxel <= 10**11 or max(self.dims) > 4096 or self.dims[0] * self.dims[1] * self.dims[2] > 2**33:
            raise Refused(f"tool grid {self.dims}")
        self.fraction_bits = max(f for f in range(11) if max(self.dims) * 2**f <= 2**20)


class SnappedMesh:
    """A snapped mesh as defined by AR-MESH-3 and AR-MESH-4."""

    def __init__(self, vertices, triangles, geometry):
        self.geometry = geometry
        scale = Fraction(2**geometry.fraction_bits, geometry.voxel)
        used = {v for triangle in triangles for v in triangle}
        self.vertices = [
            tuple(rhe((p - c) * scale) for p, c in zip(vertex, geometry.corner)) if number in used else (0, 0, 0)
            for number, vertex in enumerate(vertices)]
        for vertex in self.vertices:
            assert all(0 <= v <= n << geometry.fraction_bits <= 2**20 for v, n in zip(vertex, geometry.dims))
        self.triangles = [t for t in triangles if any(cross(*(self.vertices[v] for v in t)))]
        self.dropped = len(triangles) - len(self.triangles)

    def digest(self):
        """Computes the mesh's digest according to AR-DIG-7."""
        g = self.geometry
        data = b"OSTEONM1" + struct.pack("<I3i4qi", ARITHMETIC_VERSION, *g.dims, g.voxel, *g.corner, g.fraction_bits)
        data += struct.pack("<QQQ", len(self.vertices), len(self.triangles), self.dropped)
        assert len(data) == 84
        data += b"".join(struct.pack("<3i", *v) for v in self.vertices)
        data += b"".join(struct.pack("<3I", *t) for t in self.triangles)
        return hashlib.sha256(data).hexdigest()


def cross(v0, v1, v2):
    (ax, ay, az), (bx, by, bz) = [[p - q for p, q in zip(v, v0)] for v in (v1, v2)]
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def owns(corners, y, z):
    """Returns true if the triangle with these (y, z) corners, in counter-clockwise order, owns the point (AR-VOX-2)."""
    for (ay, az), (by, bz) in zip(corners, corners[1:] + corners[:1]):
        dy, dz = by - ay, bz - az
        e = dy * (z - az) - dz * (y - ay)
        if not (e > 0 or (e == 0 and (dz < 0 or (dz == 0 and dy > 0)))):
            return False
    return True


def crossings(mesh):
    """Returns for every owned row (j, k) a list of (first voxel of the crossing, delta) according to AR-VOX-1..3."""
    nx, ny, nz = mesh.geometry.dims
    half = Fraction(2**mesh.geometry.fraction_bits, 2)
    rows = {}
    for triangle in mesh.triangles:
        v0, v1, v2 = (mesh.vertices[v] for v in triangle)
        area = cross(v0, v1, v2)[0]
        if area == 0:
            continue
        delta = -1
        if area < 0:
            v1, v2, delta = v2, v1, +1
        normal = cross(v0, v1, v2)
        flat = [v[1:] for v in (v0, v1, v2)]
        row_range = [range(max(0, int(min(v[a] for v in flat) / (2 * half)) - 1),
                           min(n, int(max(v[a] for v in flat) / (2 * half)) + 1)) for a, n in ((0, ny), (1, nz))]
        for k in row_range[1]:
            for j in row_range[0]:
                y, z = (2 * j + 1) * half, (2 * k + 1) * half
                if owns(flat, y, z):
                    x = v0[0] - (normal[1] * (y - v0[1]) + normal[2] * (z - v0[2])) / normal[0]
                    first = ceil(x / (2 * half) - Fraction(1, 2))  # the first i with (2i + 1) half >= x
                    rows.setdefault((j, k), []).append((first, delta))
    return rows


def solid(mesh, rule="winding"):
    """Applies AR-VOX-4..6. Returns the set of solid voxels (i, j, k) and the number of leaking rows."""
    inside, leaking = set(), 0
    for (j, k), row in crossings(mesh).items():
        total = sum(delta for _, delta in row) if rule == "winding" else len(row) % 2
        if total != 0:
            leaking += 1
            continue
        for i in range(mesh.geometry.dims[0]):
            met = [delta for first, delta in row if first <= i]
            if (sum(met) if rule == "winding" else len(met) % 2) != 0:
                inside.add((i, j, k))
    return inside, leaking


class Tool(Grid):
    """A tool as defined by AR-VOX-7, AR-TOOL-3 and AR-TOOL-4: classes on a grid whose origin is the corner."""

    def __init__(self, cutting, voxel, noncutting=None, rule="winding"):
        meshes = [cutting] + ([noncutting] if noncutting else [])
        self.geometry = ToolGeometry(meshes, voxel)
        super().__init__(self.geometry.dims, (voxel,) * 3, self.geometry.corner)
        self.snapped = [SnappedMesh(*mesh, self.geometry) for mesh in meshes]
        self.dropped = sum(mesh.dropped for mesh in self.snapped)
        self.leaking_rows = 0
        for tool_class, mesh in reversed(list(enumerate(self.snapped, 1))):  # the cutting mesh is last, so it has priority
            inside, leaking = solid(mesh, rule)
            self.leaking_rows += leaking
            for at in inside:
                self.voxels[self.index(*at)] = tool_class

    def digest(self):
        return grid_digest(self, KIND_TOOL)


def self_check():
    """Checks the examples of docs/spec/arithmetic.md, sections 9, 10 and 15."""
    mm = 10**9
    reamer = ([(-18 * mm, -18 * mm, 0), (17400000000, 18 * mm, 20300000000), (0, 0, 0)], [(0, 1, 2)])
    for voxel, corner, dims in ((mm, (-19, -19, -1), (38, 38, 23)), (750000000, (-18.75, -18.75, -0.75), (50, 50, 30)),
                                (500000000, (-18.5, -18.5, -0.5), (73, 74, 43))):
        g = ToolGeometry([reamer], voxel)
        assert g.dims == dims and g.corner == tuple(int(c * mm) for c in corner) and g.fraction_bits == 10

    corners = [tuple(mm * (n >> a & 1) for a in range(3)) for n in range(8)]
    faces = [(0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 2, 3), (0, 3, 1),
             (4, 5, 7), (4, 7, 6)]
    for rule in ("winding", "parity"):
        cube = Tool((corners, faces), 500000000, rule=rule)
        assert cube.dims == (4, 4, 4) and cube.leaking_rows == 0 and sum(cube.voxels) == 8
        assert all(cube.voxels[cube.index(i, j, k)] == 1 for i in (1, 2) for j in (1, 2) for k in (1, 2))
        assert cube.digest() == "ad7035491dc6924fa37cc42501d0a7841ddae40b5aa6f9e05ba9a12fece8e4e7"
    assert cube.snapped[0].digest() == "e2dd61d51dcd7e4546f97a40558ece018087282fcee74ce609812734e178e91e"
    first = [(0, 0), (2048, 2048), (0, 2048)]   # (y, z) of the face x = 0, reversed
    second = [(0, 0), (2048, 0), (2048, 2048)]
    assert not owns(first, 512, 512) and owns(second, 512, 512)

    # The rule is the limit of a point that is moved by (e, e^2). It is tested on every lattice
    # point of random fans.
    small = Fraction(1, 10**9)
    for fan in range(40):
        ring = [((fan * 7 + n * 5) % 9 - 4, (fan * 3 + n * n) % 9 - 4) for n in range(3)]
        (y0, z0), (y1, z1), (y2, z2) = ring
        area = (y1 - y0) * (z2 - z0) - (y2 - y0) * (z1 - z0)
        if area == 0:
            continue
        ring = ring if area > 0 else [ring[0], ring[2], ring[1]]
        for y in range(-5, 6):
            for z in range(-5, 6):
                moved = all((by - ay) * (z + small**2 - az) - (bz - az) * (y + small - ay) > 0
                            for (ay, az), (by, bz) in zip(ring, ring[1:] + ring[:1]))
                assert owns(ring, y, z) == moved

    leaky = Tool((corners, faces[:-2]), 500000000)  # without the top face, which rows along x do not cross
    assert leaky.leaking_rows == 0
    leaky = Tool((corners, faces[2:]), 500000000)  # without the face x = 0
    assert leaky.leaking_rows == 4 and not any(leaky.voxels)
    inverted = Tool((corners, [(a, c, b) for a, b, c in faces]), 500000000)
    assert inverted.voxels == cube.voxels


if __name__ == "__main__":
    self_check()
    print("osteon_oracle_tool: the worked numbers of docs/spec/arithmetic.md hold")
