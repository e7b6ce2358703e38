#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""same_screen.py XWD X Y PNG: checks that the screen shows the middle of the picture, if the picture's upper left corner
is at X, Y."""
import struct
import sys
import zlib


def screen(path):
    """Returns the rows and the number of bytes per row of a file that Xvfb -fbdir writes. A pixel has 32 bits, blue first."""
    data = open(path, "rb").read()
    head = struct.unpack(">25I", data[:100])
    size, width, height, order, bits, line, colours = head[0], head[4], head[5], head[7], head[11], head[12], head[19]
    assert bits == 32 and order == 0, "unexpected format of a file of Xvfb"
    begin = size + 12 * colours
    return data[begin:begin + line * height], line, width, height


def png(path):
    """Returns the rows of a PNG file with three bytes per pixel."""
    data = open(path, "rb").read()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert depth == 8 and colour == 2
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, rows, before = zlib.decompress(packed), [], bytes(3 * width)
    for y in range(height):
        how, row = raw[y * (3 * width + 1)], bytearray(raw[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)])
        for i in range(3 * width):
            left, up, corner = (row[i - 3] if i > 2 else 0), before[i], (before[i - 3] if i > 2 else 0)
            guess = left + up - corner
            near = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, near)[how]) & 255
        rows.append(bytes(row))
        before = rows[-1]
    return rows, width, height


shown, line, across, down = screen(sys.argv[1])
x0, y0 = int(sys.argv[2]), int(sys.argv[3])
rows, width, height = png(sys.argv[4])
for y in range(height * 35 // 100, height * 70 // 100):
    for x in range(width * 40 // 100, width * 62 // 100):
        at = (y0 + y) * line + 4 * (x0 + x)
        if shown[at:at + 3][::-1] != rows[y][3 * x:3 * x + 3]:
            sys.exit("pixel %d, %d is %s on the screen, %s in the picture" % (x, y, tuple(shown[at:at + 3][::-1]), tuple(rows[y][3 * x:3 * x + 3])))
