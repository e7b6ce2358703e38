# SPDX-License-Identifier: Apache-2.0
# Definitions that the tests of DICOM series share. They write a series with make_series and compute its voxels by
# the formula in series.h.
. "${srcdir:-.}/tests/app/lib.sh"

needs DCMTK OPENJPEG
make_series=$build/tests/dicom/make_series
OSTEON_LIBEXECDIR=${OSTEON_LIBEXECDIR:-$build}
export OSTEON_LIBEXECDIR

# series FOLDER WORD...: writes a series into a folder, which may already contain other series
series() {
    mkdir -p "$1"
    "$make_series" "$@" >slices 2>make_series.err || {
        fail "make_series $*: $(cat make_series.err)"
        return 1
    }
}

# slice_file K: prints the name of the file of slice K
slice_file() {
    echo "IM$((($1 * 1741 + 5) % 4096))"
}

# Lists the values that make_series writes into the attributes that may identify a person
printf '%s\n' PLANTED 19010203 19730405 053107 098Y 2.25.777776 2.25.777771 2.25.777772 2.25.777773 >identifying

# search_files FILE...: checks that none of the listed values is in the files (unpacked if compressed) or in their names
search_files() {
    for file in "$@"; do
        checks=$((checks + 1))
        case $file in
        *.gz) gunzip -c "$file" ;;
        *) cat "$file" ;;
        esac >content
        echo "$file" >>content
        if grep -qaFf identifying content; then
            fail "$file contains an identifying value: $(grep -aFf identifying content | head -c 300)"
        fi
    done
}

# run_searched ARGUMENT...: runs a command with any status and checks its output as in `search_files`
run_searched() {
    "$osteon" "$@" >out 2>err </dev/null
    search_files out err
}

# list_searched ARGUMENT...: the same as `run_searched` for a list of series, which may contain the UIDs of the series
list_searched() {
    "$osteon" info "$@" >list.out 2>err </dev/null
    sed -E 's/(UID |"uid": ")2\.25\.777772[0-9]+/\1/' list.out >out
    search_files out err
}

# formula WORD...: prints "x y z density" for each voxel of a series written with these words, sorted by z, y, x. It is
# computed from the text of series.h; changes of single slices are not applied.
formula() {
    awk '
    function number(x) { x = int(x * 1e6 + (x < 0 ? -0.5 : 0.5)) / 1e6; return x == 0 ? "0" : sprintf("%.12g", x) }
    function nearest_even(x,   low) {
        low = int(x); if (low > x) low--
        if (x - low > 0.5 || x - low == 0.5 && low % 2 != 0) low++
        return low
    }
    # Multiplies a decimal by the power of ten that makes it an integer, so that a tie is
    # recognised.
    function decimals(text) { return index(text, ".") ? length(text) - index(text, ".") : 0 }
    function integer(text, digits) { return nearest_even(text * 10 ^ digits) }
    BEGIN {
        value["dims"] = "8,6,5"; value["spacing"] = "0.5,0.5,0.5"; value["origin"] = "-10.25,20.5,-30"
        value["rows"] = "1,0,0"; value["columns"] = "0,1,0"; value["values"] = "0,3000"
        value["slope"] = "1"; value["intercept"] = "-1024"
        for (a = 1; a < ARGC; a++) { e = index(ARGV[a], "="); value[substr(ARGV[a], 1, e - 1)] = substr(ARGV[a], e + 1) }
        split(value["dims"], n, ","); split(value["spacing"], s, ","); split(value["origin"], o, ",")
        split(value["rows"], r, ","); split(value["columns"], c, ","); split(value["values"], limit, ",")
        slopes = split(value["slope"], slope, ","); intercepts = split(value["intercept"], intercept, ",")
        paddings = split(value["padding"], padding, ",")
        normal[1] = r[2] * c[3] - r[3] * c[2]; normal[2] = r[3] * c[1] - r[1] * c[3]; normal[3] = r[1] * c[2] - r[2] * c[1]
        for (k = 0; k < n[3]; k++) for (j = 0; j < n[2]; j++) for (i = 0; i < n[1]; i++) {
            for (a = 1; a <= 3; a++) p[a] = o[a] + i * s[1] * r[a] + j * s[2] * c[a] + k * s[3] * normal[a]
            v = limit[1] + (13 * i + 1009 * j + 30011 * k + 7 * i * j * k) % (limit[2] - limit[1] + 1)
            if (i < paddings) v = padding[i + 1]
            if (value["smooth"]) v = limit[1] + value["smooth"] * (i + j + k)
            a = slope[k % slopes + 1]; b = intercept[k % intercepts + 1]
            digits = decimals(a) > decimals(b) ? decimals(a) : decimals(b)
            density = nearest_even((v * integer(a, digits) + integer(b, digits)) / 10 ^ digits)
            # The limits of the padding are in ascending or in descending order.
            if (paddings && (v - padding[1]) * (v - padding[paddings]) <= 0) density = -1024
            print number(p[1]), number(p[2]), number(p[3]), density
        }
    }' "$@" | sort -k3,3g -k2,2g -k1,1g
}

# voxels_of FILE: writes the voxels of a volume to the file voxels, in the same form as `formula`
voxels_of() {
    "$osteon" export "$1" --out voxels.txt >out 2>err || return
    awk '!/^#/ { print $1 + 0, $2 + 0, $3 + 0, $4 }' OFMT=%.12g voxels.txt | sort -k3,3g -k2,2g -k1,1g >voxels
}

# same WHAT: compares the file voxels with the file expected
same() {
    checks=$((checks + 1))
    if [ ! -s expected ] || ! cmp -s voxels expected; then
        diff voxels expected >difference
        fail "$1: $(grep -c '^[<>]' difference) lines differ: $(head -4 difference | paste -s -d ' ' -)"
    fi
}

# same_voxels WHAT FILE: compares the voxels of a volume with the file expected
same_voxels() {
    voxels_of "$2" || fail "$1: cannot export $2: $(cat err)"
    same "$1"
}

# same_bone WHAT FILE: compares the voxels of a bone with the file expected; empty voxels of the
# bone are 0 or outside its grid
same_bone() {
    voxels_of "$2" || fail "$1: cannot export $2: $(cat err)"
    for file in voxels expected; do
        awk '$4 != 0' $file >solid && mv solid $file
    done
    same "$1"
}

# plain: replaces numbers, file names and quoted strings on standard input by #, FILE and FOLDER, so that a message can
# be compared with the message in docs/reference/dicom.md
plain() {
    sed -E "s/^osteon [a-z]+: (warning: )?//; s#\\bct/[^ :;,')]+#FILE#g; s#\\bct\\b#FOLDER#g
            s/\\b[FG]\\b/FILE/g; s/\\bD\\b/FOLDER/g; s/\\b([NMXY]|UID)\\b/#/g
            s/'[^']*'/'#'/g; s/-?[0-9]+(\\.[0-9]+)*/#/g"
}

# documented FAULT: checks that a line of the file err is a message that docs/reference/dicom.md contains for the
# fault
documented() {
    checks=$((checks + 1))
    awk -F'|' -v fault="$1" '/^## /{ on = $0 == "## Faults" } on && $2 == " " fault " " { print $4 }' \
        "$source_folder/docs/reference/dicom.md" >row
    [ -s row ] || {
        fail "docs/reference/dicom.md has no fault '$1'"
        return
    }
    grep -o '`[^`]*`' row | tr -d '`' | plain | sed 's/[][\*^$.]/\\&/g; s/\\\.\\\.\\\./.*/g' >messages
    [ ! -s messages ] || plain <err | grep -qxf messages || fail "$1: the message '$(cat err)' differs from the documented message '$(cat row)'"
}
