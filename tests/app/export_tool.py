#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads exports of osteon export by the formats' specifications alone and compares them with the session's table.

  export_tool.py mcap FILE TABLE.csv     MCAP (mcap.dev/spec): records, CRCs, indexes, statistics, messages
  export_tool.py hdf5 FILE TABLE.csv     HDF5 (File Format Specification 3.0): superblock 0, object headers 1, links, arrays in one piece
  export_tool.py voxels FILE BEFORE.nrrd AFTER.nrrd   the removed voxels in HDF5, compared with two bones
"""
import csv
import json
import struct
import sys
import zlib

MAGIC = b"\x89MCAP0\r\n"


def table(name):
    with open(name, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


# ---------------------------------------------------------------------- MCAP

class Reader:
    def __init__(self, data, at=0, end=None):
        self.data, self.at, self.end = data, at, len(data) if end is None else end

    def take(self, n):
        assert n <= self.end - self.at, f"{n} bytes at {self.at}"
        self.at += n
        return self.data[self.at - n:self.at]

    def number(self, n):
        return int.from_bytes(self.take(n), "little")

    def text(self):
        return self.take(self.number(4)).decode()

    def mapping(self, key, value):
        size = self.number(4)
        part, out = Reader(self.data, self.at, self.at + size), {}
        while part.at < part.end:
            k = key(part)
            assert k not in out
            out[k] = value(part)
        self.at += size
        return out

    def records(self):
        while self.at < self.end:
            from_ = self.at
            op, size = self.number(1), self.number(8)
            self.take(size)
            yield op, from_, Reader(self.data, self.at - size, self.at)


def schema(r):
    return {"id": r.number(2), "name": r.text(), "encoding": r.text(), "data": json.loads(r.take(r.number(4)))}


def channel(r):
    return {"id": r.number(2), "schema": r.number(2), "topic": r.text(), "encoding": r.text(), "meta": r.mapping(Reader.text, Reader.text)}


def fits(value, rule, where):
    kinds = {"object": dict, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    assert isinstance(value, kinds[rule["type"]]) and (rule["type"] == "boolean" or not isinstance(value, bool)), (where, value)
    if rule["type"] == "object":
        assert set(value) == set(rule["properties"]), (where, value)
        for key, part in rule["properties"].items():
            fits(value[key], part, f"{where}.{key}")


def mcap(name):
    data = open(name, "rb").read()
    assert data[:8] == MAGIC and data[-8:] == MAGIC
    footer = Reader(data, len(data) - 8 - 29, len(data) - 8)
    assert footer.number(1) == 2 and footer.number(8) == 20
    summary, offsets, crc = footer.number(8), footer.number(8), footer.number(4)
    assert crc == zlib.crc32(data[summary:len(data) - 12]), "CRC of the summary"
    schemas, channels, messages, chunks, metadata, counts = {}, {}, [], {}, {}, {}
    ended = after = None
    for op, at, r in Reader(data, 8, summary).records():
        assert ended is None, "a record behind Data End"
        if after is not None and op != 7:
            after = None
        if op == 1:
            assert at == 8
        elif op == 3:
            s = schema(r)
            schemas[s["id"]] = s
        elif op == 4:
            c = channel(r)
            assert c["schema"] in schemas and c["encoding"] == "json"
            channels[c["id"]] = c
        elif op == 12:
            assert r.text() == "osteon session"
            metadata = r.mapping(Reader.text, Reader.text)
            metadata_at = (at, r.end - at)
        elif op == 6:
            from_, to, size, crc = r.number(8), r.number(8), r.number(8), r.number(4)
            assert r.text() == "" and r.number(8) == size and r.end - r.at == size
            body = r.take(size)
            assert zlib.crc32(body) == crc, "CRC of a chunk"
            after = {"at": at, "length": r.end - at, "from": from_, "to": to, "size": size, "index": {}, "offsets": {}, "index_bytes": 0}
            here = {}
            for inner, place, m in Reader(body).records():
                assert inner == 5
                c, sequence, t, published = m.number(2), m.number(4), m.number(8), m.number(8)
                assert c in channels and t == published and from_ <= t <= to
                assert sequence == counts.get(c, 0)
                counts[c] = sequence + 1
                messages.append((c, t, json.loads(m.take(m.end - m.at))))
                here.setdefault(c, []).append((t, place))
            after["index"] = here
            assert min(t for part in here.values() for t, _ in part) == from_ and max(t for part in here.values() for t, _ in part) == to
            chunks[at] = after
        elif op == 7:
            c, size = r.number(2), r.number(4)
            entries = [(r.number(8), r.number(8)) for _ in range(size // 16)]
            assert after["index"].pop(c) == entries and r.at == r.end
            after["offsets"][c] = at
            after["index_bytes"] += r.end - at
        elif op == 15:
            assert r.number(4) == zlib.crc32(data[:at]), "CRC of the data"
            ended = at
        else:
            raise AssertionError(f"record {op} in the data")
    assert ended is not None and all(not c["index"] for c in chunks.values()), "messages without an index"
    groups, seen = {}, 0
    for op, at, r in Reader(data, summary, offsets).records():
        groups.setdefault(op, [at, 0])
        assert sum(groups[op]) == at, "records of one kind lie apart"
        groups[op][1] += r.end - at
        if op == 3:
            s = schema(r)
            assert schemas[s["id"]] == s
        elif op == 4:
            c = channel(r)
            assert channels[c["id"]] == c
        elif op == 8:
            from_, to, at_, length = r.number(8), r.number(8), r.number(8), r.number(8)
            places = r.mapping(lambda x: x.number(2), lambda x: x.number(8))
            c = chunks[at_]
            assert (c["from"], c["to"], c["length"], c["offsets"], c["index_bytes"]) == (from_, to, length, places, r.number(8))
            assert r.text() == "" and r.number(8) == c["size"] and r.number(8) == c["size"]
            seen += 1
        elif op == 11:
            counts = [r.number(8), r.number(2), r.number(4), r.number(4), r.number(4), r.number(4)]
            assert counts == [len(messages), len(schemas), len(channels), 0, 1, len(chunks)], counts
            times = [t for _, t, _ in messages] or [0]
            assert [r.number(8), r.number(8)] == [min(times), max(times)]
            each = r.mapping(lambda x: x.number(2), lambda x: x.number(8))
            assert each == {c: sum(1 for m in messages if m[0] == c) for c in channels}
        elif op == 13:
            assert (r.number(8), r.number(8)) == metadata_at and r.text() == "osteon session"
        else:
            raise AssertionError(f"record {op} in the summary")
    assert seen == len(chunks) and groups.keys() >= {3, 4, 11, 13}
    told = {}
    for op, _, r in Reader(data, offsets, len(data) - 8 - 29).records():
        assert op == 14
        group = r.number(1)
        told[group] = [r.number(8), r.number(8)]
    assert told == groups
    for c, _, value in messages:
        fits(value, schemas[channels[c]["schema"]]["data"], channels[c]["topic"])
    return channels, schemas, messages, metadata


def check_mcap(name, rows):
    channels, schemas, messages, metadata = mcap(name)
    by_topic = {c["topic"]: [(t, v) for k, t, v in messages if k == i] for i, c in channels.items()}
    names = {c["topic"]: schemas[c["schema"]]["name"] for c in channels.values()}
    assert names["/tool/pose"] == "foxglove.PoseInFrame" and names["/note"] == "foxglove.Log"
    assert metadata["format"] == "osteon session 2" and metadata["mcap.time_shift_ns"] == "0"
    assert len(by_topic["/tool/pose"]) == len(by_topic["/tick"]) == len(rows)
    felt = [r for r in rows if r["force_given"] == "1" or any(r[f"{w}_{a}_{u}"] != "0" for w, u in (("force", "un"), ("torque", "unm")) for a in "xyz")]
    assert len(by_topic["/hand/wrench"]) == len(felt)
    for row, (t, pose), (u, tick) in zip(rows, by_topic["/tool/pose"], by_topic["/tick"]):
        assert t == u == round(float(row["t_s"]) * 1e9) == pose["timestamp"]["sec"] * 10 ** 9 + pose["timestamp"]["nsec"]
        for a in "xyz":
            assert abs(pose["pose"]["position"][a] * 1e3 - float(row[a + "_mm"])) < 1e-9
        for a in "xyzw":
            assert abs(pose["pose"]["orientation"][a] - float(row["q" + a])) < 1e-12
        for key in ("tick", "tool", "poses", "removed_voxels", "touched_voxels", "buttons", "fault", "wake_ns", "exec_ns", "missed"):
            assert tick[key] == int(row[key])
        for key in ("removal", "met", "force_given", "declared"):
            assert tick[key] == (row[key] == "1")
        assert tick["digest"] == row["digest"]
    for row, (_, wrench) in zip(felt, by_topic["/hand/wrench"]):
        for a in "xyz":
            assert abs(wrench["force"][a] * 1e6 - int(row[f"force_{a}_un"])) < 1e-6
            assert abs(wrench["torque"][a] * 1e6 - int(row[f"torque_{a}_unm"])) < 1e-6
    print(len(rows), "ticks,", len(felt), "forces")


# ---------------------------------------------------------------------- HDF5

def node(data, at, path, out):
    version, _, count, references, size = struct.unpack_from("<BBHII", data, at)
    assert version == 1 and references == 1
    p, end, parts, links = at + 16, at + 16 + size, {}, []
    for _ in range(count):
        kind, length, flags = struct.unpack_from("<HHB", data, p)
        assert length % 8 == 0 and flags == 0
        body = data[p + 8:p + 8 + length]
        if kind == 6:
            assert body[0] == 1 and body[1] == 0
            n = body[2]
            links.append((body[3:3 + n].decode(), struct.unpack_from("<Q", body, 3 + n)[0]))
        else:
            parts[kind] = body
        p += 8 + length
    assert p == end
    if 2 in parts:
        assert parts[2][:18] == b"\0\0" + b"\xff" * 16
        out[path or "/"] = None
        for name, to in links:
            node(data, to, f"{path}/{name}", out)
        return
    assert parts[1][0] == 1 and parts[8][:2] == b"\x03\x01" and parts[5] == bytes([2, 2, 2, 1, 0, 0, 0, 0])
    dims = struct.unpack_from(f"<{parts[1][1]}Q", parts[1], 8)
    kind, (width,) = parts[3][0], struct.unpack_from("<I", parts[3], 4)
    place, size = struct.unpack_from("<QQ", parts[8], 2)
    count = 1
    for d in dims:
        count *= d
    assert size == count * width and (place + size <= len(data) if size else place == 2 ** 64 - 1)
    if kind == 0x11:
        assert parts[3][1:24] == bytes([0x20, 0x3f, 0, 8, 0, 0, 0, 0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0, 0, 0, 0, 0])
        value = struct.unpack_from(f"<{count}d", data, place) if size else ()
    elif kind == 0x10:
        assert parts[3][1:4] == b"\x08\0\0" and width == 8
        value = struct.unpack_from(f"<{count}q", data, place) if size else ()
    else:
        assert kind == 0x13 and not dims
        value = data[place:place + size].decode()
    out[path] = (dims, value)


def hdf5(name):
    data = open(name, "rb").read()
    assert data[:8] == b"\x89HDF\r\n\x1a\n" and data[8:16] == bytes([0, 0, 0, 0, 0, 8, 8, 0])
    base, free, end, driver, link, root, cache = struct.unpack_from("<QQQQQQI", data, 24)
    assert (base, free, end, driver, link, cache) == (0, 2 ** 64 - 1, len(data), 2 ** 64 - 1, 0, 0)
    out = {}
    node(data, root, "", out)
    return out


def check_hdf5(name, rows):
    h = hdf5(name)
    for group in ("/metadata_v3", "/vision_data/intermittent_data", "/vision_data/continuous_data", "/physics_data/intermittent_data/voxels_removed",
                  "/physics_data/intermittent_data/burr_change", "/physics_data/intermittent_data/drill_force_feedback",
                  "/physics_data/continuous_data/high_frequency_poses/drill_pose"):
        assert h[group] is None, group
    assert "metres" in h["/metadata_v3/README"][1] and "format: osteon session 2" in h["/metadata_v3/osteon_session"][1]
    drill = "/physics_data/continuous_data/high_frequency_poses/drill_pose/"
    dims, poses = h[drill + "pose"]
    times = h[drill + "time_stamp"][1]
    assert dims == (len(rows), 7) and len(times) == len(rows)
    removed, tools, forces = [], [], []
    for i, row in enumerate(rows):
        t = float(row["t_s"])
        expected = [float(row[a + "_mm"]) / 1e3 for a in "xyz"] + [float(row["q" + a]) for a in "xyzw"]
        assert abs(times[i] - t) < 1e-9 and all(abs(a - b) < 1e-9 for a, b in zip(poses[7 * i:7 * i + 7], expected))
        if row["removed_voxels"] != "0":
            removed.append((t, int(row["removed_voxels"])))
        if not tools or tools[-1][1] != int(row["tool"]):
            tools.append((t, int(row["tool"])))
        wrench = [int(row[f"force_{a}_un"]) / 1e6 for a in "xyz"] + [int(row[f"torque_{a}_unm"]) / 1e6 for a in "xyz"]
        if row["force_given"] == "1" or any(wrench):
            forces.append((t, wrench))
    events = "/physics_data/intermittent_data/"
    assert [round(x, 9) for x in h[events + "voxels_removed/voxel_time_stamp"][1]] == [t for t, _ in removed]
    assert list(h[events + "voxels_removed/voxel_count"][1]) == [n for _, n in removed]
    assert list(h[events + "burr_change/tool"][1]) == [n for _, n in tools]
    dims, values = h[events + "drill_force_feedback/wrench"]
    assert dims == (len(forces), 6) and len(h[events + "drill_force_feedback/time_stamp"][1]) == len(forces)
    assert all(abs(values[6 * i + k] - w[k]) < 1e-12 for i, (_, w) in enumerate(forces) for k in range(6))
    slow = h["/vision_data/continuous_data/time"][1]
    assert h["/vision_data/continuous_data/pose_mastoidectomy_drill"][0] == (len(slow), 7) and all(b - a > 0.0199 for a, b in zip(slow, slow[1:]))
    assert len(slow) >= len(rows) // 20
    print(len(rows), "ticks,", len(forces), "forces")


def bone(name):
    head, data = open(name, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().split("\n") if ": " in line)
    assert fields["encoding"] == "raw" and fields["type"] == "int16" and fields["endian"] == "little"
    dims = [int(n) for n in fields["sizes"].split()]
    return dims, struct.unpack(f"<{dims[0] * dims[1] * dims[2]}h", data)


def check_voxels(name, before, after):
    h = hdf5(name)
    (nx, ny, _), old = bone(before)
    new = bone(after)[1]
    group = "/physics_data/intermittent_data/voxels_removed/"
    (count, four), rows = h[group + "voxel_removed"]
    times, each = h[group + "voxel_time_stamp"][1], h[group + "voxel_count"][1]
    assert four == 4 and h[group + "voxel_color"][0] == (count, 5) and len(times) == len(each)
    colours = h[group + "voxel_color"][1]
    went = {}
    for i in range(count):
        g, x, y, z = (int(v) for v in rows[4 * i:4 * i + 4])
        at = x + nx * (y + ny * z)
        assert at not in went and 0 <= g < len(times)
        went[at] = g
        grey = min(max(old[at] // 8, 0), 255)
        assert [int(v) for v in colours[5 * i:5 * i + 5]] == [g, grey, grey, grey, 255]
    assert set(went) == {i for i in range(len(old)) if old[i] != new[i]}
    assert list(each) == [sum(1 for v in went.values() if v == g) for g in range(len(times))]
    assert all(b > a for a, b in zip(times, times[1:]))
    print(count, "voxels")


def main():
    if sys.argv[1] == "voxels":
        check_voxels(*sys.argv[2:5])
        return
    what, name, rows = sys.argv[1], sys.argv[2], table(sys.argv[3])
    {"mcap": check_mcap, "hdf5": check_hdf5}[what](name, rows)


main()
