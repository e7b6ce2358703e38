# SPDX-License-Identifier: Apache-2.0
"""Implements poses, sweep, map and removal as defined in docs/spec/arithmetic.md, sections 5 and 11 to 14."""

import itertools
import math
from fractions import Fraction

import motor_table
from osteon_oracle import LENGTH_MAX, Refused, decimal, floor, length, rhe

Q = 2**30


class Pose:
    """A pose as defined by AR-POSE-1: t in picometres, q times 2^30."""

    def __init__(self, t, q):
        self.t, self.q = tuple(t), tuple(q)

    @classmethod
    def from_decimals(cls, texts):
        """Makes a pose according to AR-POSE-2 and AR-POSE-3 from the seven decimals x y z qw qx qy qz."""
        values = [decimal(text)[0] for text in texts]
        pose = cls([length(v) for v in values[:3]], [rhe(v * Q) for v in values[3:]])
        if not 999**2 * 2**60 <= 10**6 * pose.norm <= 1001**2 * 2**60:
            raise Refused("a quaternion that is not a unit")
        assert all(abs(t) <= LENGTH_MAX for t in pose.t)
        return pose

    @property
    def norm(self):
        return sum(c * c for c in self.q)

    @property
    def matrix(self):
        """Returns the matrix M of AR-POSE-4, with R = M / norm."""
        w, x, y, z = self.q
        return ((w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
                (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
                (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z))

    def image(self, point):
        """Returns the position of a point of the tool at this pose according to AR-SWEEP-1."""
        return tuple(rhe(Fraction(sum(m * c for m, c in zip(row, point)), self.norm)) + t for row, t in zip(self.matrix, self.t))


def dot(a, b):
    return sum(p * q for p, q in zip(a.q, b.q))


def sweep_count(a, b, tool, bone_voxel):
    """Returns the number of poses from a to b according to AR-SWEEP-2 and AR-SWEEP-3."""
    if 2 * dot(a, b) ** 2 < a.norm * b.norm:
        raise Refused("a turn of more than 90 degrees")
    ends = [(c, c + n * tool.spacing[0]) for c, n in zip(tool.origin, tool.dims)]
    square = max(sum((p - q) ** 2 for p, q in zip(b.image(c), a.image(c))) for c in itertools.product(*ends))
    n = 1
    while 4 * square > n * n * bone_voxel**2:
        n += 1
        if n > 4096:
            raise Refused("a sweep of more than 4096 poses")
    return n


def sweep_pose(a, b, k, n):
    """Returns pose k of n from a to b according to AR-SWEEP-4."""
    sign = -1 if dot(a, b) < 0 else 1
    return Pose([rhe(Fraction((n - k) * p + k * q, n)) for p, q in zip(a.t, b.t)],
                [rhe(Fraction((n - k) * p + k * sign * q, n)) for p, q in zip(a.q, b.q)])


TURN = 6 * 10**10
ROTATIONS = motor_table.rotations(motor_table.table())
UNKNOWN = None  # AR-MOTOR-1: an unknown speed


class Motor:
    """A motor as defined by AR-MOTOR-2 to AR-MOTOR-4."""

    def __init__(self):
        self.phase, self.time = 0, None

    def turn(self, t_ns, hand, rpm):
        """Returns the tool's pose at a tick."""
        if self.time is not None and rpm:
            self.phase = (self.phase + rpm * (t_ns - self.time)) % TURN
        self.time = t_ns
        if rpm is UNKNOWN:
            return hand
        (w, x, y, z), (c, s) = hand.q, ROTATIONS[4096 * self.phase // TURN]
        return Pose(hand.t, [rhe(Fraction(n, Q)) for n in (w * c + z * s, x * c - y * s, y * c + x * s, z * c - w * s)])


def ticks_of_rows(rows, rpm):
    """Converts the rows of a device to rows of ticks according to AR-MOTOR-7. The ticks still have the poses of the device."""
    before = None
    for row in rows:
        m = 1
        if before and before.tool == row.tool and not row.lifted and rpm:
            m = max(1, -(-8 * rpm * (row.t_ns - before.t_ns) // TURN))
            if m > 4096 or m > 1 and 2 * dot(before.pose, row.pose) ** 2 < before.pose.norm * row.pose.norm:
                raise Refused("rows too far from each other")
        for j in range(1, m):
            between = sweep_pose(before.pose, row.pose, j, m)
            r = math.isqrt(between.norm)
            yield Row(before.t_ns + j * (row.t_ns - before.t_ns) // m, row.tool, False,
                      Pose(between.t, [rhe(Fraction(Q * c, r)) for c in between.q]))
        yield row
        before = row


class Map:
    """The map of a pose as defined by AR-MAP."""

    def __init__(self, pose, bone, tool):
        s, st = bone.spacing[0], tool.spacing[0]
        if s > 16 * st or max(tool.dims) > 1024:
            raise Refused("a tool too fine or too wide for the map")
        m, norm = pose.matrix, pose.norm
        self.divisor = norm * st
        self.column = [[2**20 * m[b][a] * s for a in range(3)] for b in range(3)]
        self.origin = [2**20 * (sum(m[b][a] * (bone.origin[b] - pose.t[b]) for b in range(3)) - norm * tool.origin[a])
                       for a in range(3)]
        self.step = [[rhe(Fraction(c, self.divisor)) for c in row] for row in self.column]
        self.bases = {}

    def exact(self, voxel):
        """Returns the exact tool coordinates of a bone voxel according to AR-MAP-1."""
        return [Fraction(self.origin[a] + sum(i * self.column[b][a] for b, i in enumerate(voxel)), self.divisor) for a in range(3)]

    def used(self, voxel):
        """Returns the rounded tool coordinates that are used for a bone voxel according to AR-MAP-4."""
        i, j, k = voxel
        block = (i // 16, j // 16, k // 16)
        base = self.bases.get(block)
        if base is None:
            base = self.bases[block] = [rhe(u) for u in self.exact([16 * b for b in block])]
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.step
        i, j, k = i % 16, j % 16, k % 16
        return [base[0] + i * xx + j * yx + k * zx, base[1] + i * xy + j * yy + k * zy, base[2] + i * xz + j * yz + k * zz]

    def tool_class(self, voxel, tool):
        """Returns the class of the tool voxel over a bone voxel, 0 outside the tool."""
        x, y, z = self.used(voxel)
        x, y, z = x >> 20, y >> 20, z >> 20
        nx, ny, nz = tool.dims
        return tool.voxels[x + nx * (y + ny * z)] if 0 <= x < nx and 0 <= y < ny and 0 <= z < nz else 0


DEFAULT_CLASSES = (("cartilage", 120), ("cancellous", 150), ("cortical", 650))


def class_of(density, classes=DEFAULT_CLASSES):
    """Returns the density class according to AR-CLS-1."""
    return max((c for c, (_, border) in enumerate(classes) if border <= density), default=0)


class Session:
    """Performs ticks on a bone with one tool or several according to AR-SWEEP-5, AR-MOTOR-5, AR-MOTOR-6 and AR-REM."""

    def __init__(self, bone, tools, sweep=True, period_ns=0, classes=DEFAULT_CLASSES):
        self.bone, self.tools, self.sweep, self.period, self.classes = bone, tools, sweep, period_ns, classes
        self.tool = self.last_pose = self.last_time = self.before = None
        self.running, self.turned = False, 0
        self.ticks = self.removals = self.removed = self.poses = 0
        self.by_class = [0] * len(classes)
        self.density_by_class = [0] * len(classes)

    def tick(self, t_ns, pose, tool=0, lifted=False, rpm=UNKNOWN):
        self.ticks += 1
        selected = tool != self.tool or lifted
        if self.before is not None and rpm and not selected:
            self.turned += rpm * (t_ns - self.before)
        self.before, was_running, self.running = t_ns, self.running, rpm != 0
        if rpm == 0:
            self.tool, self.last_pose, self.turned = tool, pose, 0
            return
        if not selected and was_running and self.period and t_ns // self.period == self.last_time // self.period:  # AR-REM-7
            return
        shape = self.tools[tool]
        if not selected and self.sweep and 4 * self.turned > TURN:
            raise Refused("a motor that turns by more than 90 degrees between two events")
        self.turned = 0
        if selected or not self.sweep:
            poses = [pose]
        else:
            n = sweep_count(self.last_pose, pose, shape, self.bone.spacing[0])
            poses = [sweep_pose(self.last_pose, pose, k, n) for k in range(1, n + 1)]
        self.tool, self.last_pose, self.last_time = tool, pose, t_ns
        self.event(poses, shape)

    def event(self, poses, tool):
        """Removes the hit voxels according to AR-REM-1, AR-REM-2 and AR-REM-6. Returns the hit and the touched voxels."""
        self.removals += 1
        self.poses += len(poses)
        maps = [Map(pose, self.bone, tool) for pose in poses]
        hit, touched = [], []
        for voxel in self.bone.active():
            classes = {m.tool_class(voxel, tool) for m in maps}
            if 1 in classes:
                hit.append(voxel)
            elif 2 in classes:
                touched.append(voxel)
        for voxel in hit:
            at = self.bone.index(*voxel)
            kind = class_of(self.bone.voxels[at], self.classes)
            self.by_class[kind] += 1
            self.density_by_class[kind] += self.bone.voxels[at]
            self.bone.voxels[at] = 0
        self.removed += len(hit)
        return hit, touched


class Row:
    def __init__(self, t_ns, tool, lifted, pose):
        self.t_ns, self.tool, self.lifted, self.pose = t_ns, tool, lifted, pose  # pose is None for a row without a pose


def integer(text, least, most):
    value = decimal(text)
    if value is None or value[0].denominator != 1 or not least <= value[0] <= most:
        raise Refused(f"'{text}' is no integer from {least} to {most}")
    return int(value[0])


def read_rows(content):
    """Returns the rows according to AR-PATH-1 to AR-PATH-3, and whether there is a column `lifted`."""
    names, rows, first = None, [], True
    for line in content.splitlines():
        fields = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not fields:
            continue
        if first and all(decimal(f) is None and f.lower() != "nan" for f in fields):
            names = fields
            if names[:8] not in [["t_s", *(f"{a}_{unit}" for a in "xyz"), "qw", "qx", "qy", "qz"] for unit in ("mm", "m")]:
                raise Refused("columns of a path")
            first = False
            continue
        first = False
        if names is None:
            if len(fields) not in (8, 9) or rows and len(fields) != columns:
                raise Refused("a row without a header has eight or nine fields")
            columns = len(fields)
        read = names or ["t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "tool"][:columns]
        value = dict(zip(read, fields))
        lost = any(f.lower() == "nan" for f in fields[1:8])
        t_ns = rhe(decimal(fields[0])[0] * 10**9)
        if abs(t_ns) > 4 * 10**18 or rows and t_ns <= rows[-1].t_ns:
            raise Refused("a time")
        at = fields[1:4] if read[1] == "x_mm" else [f + "e3" if "e" not in f.lower() else None for f in fields[1:4]]
        rows.append(Row(t_ns, integer(value.get("tool", "0"), 0, 2**31 - 1), integer(value.get("lifted", "0"), 0, 1) == 1,
                        None if lost else Pose.from_decimals([*at, *fields[4:8]])))
    return rows, names is not None and "lifted" in names


def read_path(content, max_gap=None):
    """Returns a list of rows with poses according to AR-PATH-4 and AR-PATH-5. max_gap is None or (T in ns, D in pm); T or D may be
    None, which means no limit."""
    rows, says = read_rows(content)
    ticks, lost = [], False
    for row in rows:
        if row.pose is not None:
            row.lifted = bool(ticks) and (row.lifted or lost)
            ticks.append(row)
        lost = row.pose is None
    pairs = [(a, b) for a, b in zip(ticks, ticks[1:]) if a.tool == b.tool and not b.lifted]
    times = [b.t_ns - a.t_ns for a, b in pairs]
    ways = [sum((p - q)**2 for p, q in zip(a.pose.t, b.pose.t)) for a, b in pairs]
    if max_gap is None and (says or not pairs):
        return ticks
    if max_gap is None:
        middle = (len(pairs) - 1) // 2
        longest, farthest = max(50 * 10**6, 10 * sorted(times)[middle]), max((5 * 10**9)**2, 100 * sorted(ways)[middle])
    else:
        longest, farthest = max_gap[0], None if max_gap[1] is None else max_gap[1]**2
    for (_, b), time, way in zip(pairs, times, ways):
        b.lifted = longest is not None and time > longest or farthest is not None and way > farthest
    return ticks


def join(paths, tool_count):
    """Joins paths to one according to AR-PATH-6."""
    ticks = []
    for k, path in enumerate(paths):
        if all(row.tool == 0 for row in path):
            for row in path:
                row.tool = k if tool_count > 1 else 0
        if any(row.tool >= tool_count for row in path):
            raise Refused("a tool that is not there")
        if ticks:
            shift = ticks[-1].t_ns + 10**6 - path[0].t_ns
            path[0].lifted = True
            for row in path:
                row.t_ns += shift
        ticks += path
    return ticks


def period(rate):
    """Returns the period in nanoseconds for a frequency given as a decimal in hertz according to AR-PATH-7."""
    u = rhe(decimal(rate)[0] * 10**6)
    if not 10**3 <= u <= 10**12:
        raise Refused(f"rate {rate}")
    return 10**15 // u


def self_check():
    """Checks the examples of docs/spec/arithmetic.md, sections 5 and 11 to 14."""
    from osteon_oracle import Bone, Grid

    def lifted(times):
        return [row.lifted for row in read_path("".join(f"{t} 0 0 0 1 0 0 0\n" for t in times))]
    assert lifted(["0", "0.0035", "0.007", "0.0105", "0.1085", "0.112"]) == [False] * 4 + [True, False]
    assert not any(lifted(["0", "1", "2", "3"]))
    assert period("400") == 2500000 and period("30") == 33333333

    quarter = Pose.from_decimals(["0"] * 3 + ["0.707107", "0", "0", "0.707107"])
    assert quarter.q == (759250360, 0, 0, 759250360) and quarter.norm == 1152922218320259200
    assert quarter.image((1, 0, 0)) == (0, 1, 0) and quarter.image((0, 1, 0)) == (-1, 0, 0)

    bone = Grid((1, 1, 1), (470000000,) * 3, (-57340000000, -54755000000, 0))
    tool = Grid((1, 1, 1), (500000000,) * 3, (-18500000000, -18500000000, -500000000))
    m = Map(Pose.from_decimals("12 -7.5 30.25 0.8 0 0.6 0".split()), bone, tool)
    assert m.divisor == 576460751873926758500000000
    assert m.origin == [34000796832371564562559795200000000, -34762661917118460467698728960000000,
                        -90108978398322049941535457280000000]
    assert m.step == [[275985, 0, 946235], [0, 985661, 0], [-946235, 0, 275985]]
    assert [rhe(u) for u in m.exact((144, 96, 64))] == [38164811, 34319892, -2393270]
    assert m.used((149, 103, 75)) == [29136151, 41219519, 5373740]
    assert all(abs(u - e) <= 23 for u, e in zip(m.used((149, 103, 75)), m.exact((149, 103, 75))))
    assert 15 * (Fraction(173205081, 10**8) * 2**24 + Fraction(3, 2)) < 435884881 + 1 < 2**29

    one = (Q, 0, 0, 0)
    a, b = Pose((0, 0, 0), one), Pose((300000000, 400000000, 0), one)
    assert sweep_count(a, b, tool, 470000000) == 3
    assert sweep_pose(a, b, 1, 3).t == (100000000, 133333333, 0) and sweep_pose(a, b, 3, 3).t == b.t
    assert sweep_pose(a, Pose(b.t, (-Q, 0, 0, 0)), 1, 3).q == one
    for q in ((0, Q, 0, 0), (500000000, 950000000, 0, 0)):
        try:
            sweep_count(a, Pose((0, 0, 0), q), tool, 470000000)
        except Refused:
            continue
        raise AssertionError("a turn of more than 90 degrees")

    motor, hand = Motor(), Pose((0, 0, 0), one)
    assert motor.turn(0, hand, 200).q == one and motor.turn(10**6, hand, 200).q == (1073688450, 0, 0, -10705968)
    for k in range(2, 301):
        turned = motor.turn(k * 10**6, hand, 200)
    assert turned.q == one and motor.phase == 0
    assert [row.t_ns for row in ticks_of_rows([Row(0, 0, False, hand), Row(10**8, 0, False, hand)], 200)] == [0, 33333333, 66666666, 10**8]

    assert [class_of(d) for d in (1, 119, 120, 149, 150, 649, 650, 3000)] == [0, 0, 0, 0, 1, 1, 2, 2]

    # A block of bone with voxels of 1 mm, and a tool of 4^3 voxels of 1 mm that moves along x, so
    # that the remaining voxels are easily counted.
    mm = 10**9
    bone = Bone(Grid((20, 20, 20), (mm,) * 3, (0, 0, 0), [700] * 8000))
    box = Grid((4, 4, 4), (mm,) * 3, (-2 * mm,) * 3, [1] * 64)
    session = Session(bone, [box])
    half = mm // 2  # places the centres of bone voxels at tool voxel centres
    session.tick(0, Pose((2 * mm - half, 2 * mm - half, 2 * mm - half), one))
    assert session.removed == 64
    session.tick(1, Pose((7 * mm - half, 2 * mm - half, 2 * mm - half), one))
    assert session.removed == 9 * 16 and session.poses == 1 + 10 and session.by_class == [0, 0, 144]
    # A tool corner lies on voxel centres. The tool removes the voxels on its low side but not
    # those on its high side (half-open).
    bone = Bone(Grid((8, 1, 1), (mm,) * 3, (0, 0, 0), [700] * 8))
    Session(bone, [box]).tick(0, Pose((4 * mm, 0, 0), one))
    assert bone.voxels == [700, 700, 0, 0, 0, 0, 700, 700]


if __name__ == "__main__":
    self_check()
    print("osteon_oracle_events: the worked numbers of docs/spec/arithmetic.md hold")
