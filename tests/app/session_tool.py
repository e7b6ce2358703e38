#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A second implementation of docs/spec/session.md, which reads and changes sessions.

  session_tool.py check FILE              checks every checksum and rule; prints the number of ticks and the digest of
                                          a step that removed nothing
  session_tool.py change FILE OUT TICK FIELD DELTA
                                          adds DELTA to a field of a tick and corrects the checksums
"""
import hashlib
import struct
import sys
import zlib

MAGIC = bytes.fromhex("894f53545345530a")
FIELDS = {"x": (24, "<q"), "digest": (72, "<Q"), "removed": (80, "<I"), "tool": (64, "<i"), "t": (16, "<q")}


def blocks(data):
    at, sequence, first, identity = 0, 0, 0, None
    while at < len(data):
        own = data[at:at + 64]
        kind, payload, seq, first_record, records, crc, ident, version, lost, zero, own_crc = struct.unpack("<IIQQIIIIQII", own[8:])
        assert own[:8] == MAGIC and own_crc == zlib.crc32(own[:60]), f"block at {at}"
        assert seq == sequence and version == 2 and zero == 0 and payload % 64 == 0
        body = data[at + 64:at + 64 + payload]
        assert len(body) == payload and zlib.crc32(body) == crc
        identity = crc if identity is None else identity
        assert ident == identity
        assert (kind == 1) == (seq < 2)
        if kind == 2:
            assert records * 128 == payload and first_record == first and 1 <= records <= 4096
            first += records
        yield at, kind, body
        sequence += 1
        at += 64 + payload


def mix(x):
    m = 2 ** 64 - 1
    x = x + 0x9e3779b97f4a7c15 & m
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9 & m
    x = (x ^ x >> 27) * 0x94d049bb133111eb & m
    return x ^ x >> 31


def check(data):
    ticks, heads, ended = 0, [], False
    for _, kind, body in blocks(data):
        if kind == 1:
            heads.append(body)
            continue
        for i in range(0, len(body), 128):
            record = body[i:i + 128]
            which, = struct.unpack_from("<H", record)
            if which == 1:
                number, = struct.unpack_from("<Q", record, 8)
                flags, = struct.unpack_from("<I", record, 4)
                digest, = struct.unpack_from("<Q", record, 72)
                assert number == ticks
                if not flags & 1:
                    assert digest == mix(0)
                ticks += 1
            ended = which == 3
    assert len(heads) == 2 and heads[0] == heads[1]
    text = heads[0].rstrip(b"\0").decode("utf-8")
    lines = text.split("\n")
    assert lines[-1] == ""
    keys = dict(line.split(": ", 1) for line in lines[:-1])
    config = "".join(line + "\n" for line in lines if line.startswith("config."))
    assert keys["config_sha256"] == hashlib.sha256(config.encode()).hexdigest()
    print(ticks, "ended" if ended else "cut off")


def change(data, tick, field, delta):
    data = bytearray(data)
    place, code = FIELDS[field]
    for at, kind, body in blocks(bytes(data)):
        if kind != 2:
            continue
        for i in range(0, len(body), 128):
            start = at + 64 + i
            if struct.unpack_from("<H", data, start)[0] == 1 and struct.unpack_from("<Q", data, start + 8)[0] == tick:
                value, = struct.unpack_from(code, data, start + place)
                struct.pack_into(code, data, start + place, value + delta)
                struct.pack_into("<I", data, at + 36, zlib.crc32(data[at + 64:at + 64 + len(body)]))
                struct.pack_into("<I", data, at + 60, zlib.crc32(data[at:at + 60]))
                return bytes(data)
    sys.exit(f"no tick {tick}")


if sys.argv[1] == "check":
    check(open(sys.argv[2], "rb").read())
else:
    changed = change(open(sys.argv[2], "rb").read(), int(sys.argv[4]), sys.argv[5], int(sys.argv[6]))
    open(sys.argv[3], "wb").write(changed)
