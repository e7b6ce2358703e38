#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Mesh files with more triangles than the documented limit must be refused before memory is
# allocated for them. The test limits the address space to 1 GB; the files would need 3 GB or more.
# Covers: REQ-MESH-LIMITS
. "${srcdir:-.}/tests/app/lib.sh"
need_part assimp "built without assimp"
[ -z "${OST_SAN_CFLAGS:-}" ] || {
    echo "skipped: a sanitizer needs terabytes of address space"
    exit 77
}

# within_limit FILE: prints "status, message" of osteon info in an address space of 1 GB
within_limit() {
    (
        ulimit -v 1000000 || exit 99
        "$osteon" info "$1" >out 2>err
    )
    echo "$? $(cat err)"
}

# Makes a binary STL of 80,000,000 triangles (0x04c4b400). Only its first bytes are stored on the
# disk.
{
    head -c 80 /dev/zero
    printf '\000\264\304\004'
} >huge.stl
if dd if=/dev/null of=huge.stl bs=1 seek=4000000084 2>/dev/null; then
    check "80 million triangles" "$(within_limit huge.stl)" \
        "2 osteon info: huge.stl: byte 80: 80000000 triangles; at most 8388608 are read: simplify the mesh"
    rm huge.stl
fi
# Makes a shorter file with the same number of triangles, which must be refused because of its size.
{
    head -c 80 /dev/zero
    printf '\000\264\304\004'
    head -c 100000 /dev/zero
} >short.stl
check "80 million triangles in a file that is too short" "$(within_limit short.stl)" \
    "2 osteon info: short.stl: byte 80: the header states 80000000 triangles, which take 4000000084 bytes; the file has 100084 (truncated, or not an STL file)"

# Makes an OBJ of 19 MB. Its polygons have 900 corners, with two bytes per corner, and give
# 9,000,000 triangles.
awk 'BEGIN {
    for (i = 0; i < 9; i++) printf "v %d %d 0\n", 10 * (i % 3), 10 * int(i / 3)
    for (i = 0; i < 100; i++) corners = corners " 1 2 3 4 5 6 7 8 9"
    for (i = 0; i < 10022; i++) print "f" corners
}' >fan.obj
check "an OBJ of 9 million triangles" "$(within_limit fan.obj)" "2 osteon info: fan.obj: more than 8388608 triangles; simplify the mesh"
finish
