#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Exports sessions as tables and compares them with the recorded data: the ticks of the path, the
# removed voxels that a replay counts, and times before zero. A format that osteon does not write
# must be refused with the name of the table.
# Covers: REQ-SESSION-EXPORT
. "${srcdir:-.}/tests/app/lib.sh"

run 0 phantom glenoid --spacing 1 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 sim --headless --no-clock --bone bone.nrrd --path builtin:glenoid-ream --seconds 2 --record felt.session
# Records an operation with two tools and a path that begins before time 0.
{ echo "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool"; echo "-0.5,0,0,0,1,0,0,0,0"; echo "-0.25,0,0,1,1,0,0,0,1"; echo "0.125,0,0,2,0.6,0,-0.8,0,0"; } >early.csv
run 0 ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path early.csv --out r.nrrd --record early.session

run 0 export felt.session --out felt.csv --json
has ticks
first=$(value file_sha256)
run 0 export felt.session --out again.csv --json
check "digest of a second export" "$(value file_sha256)" "$first"
check "lines of the table" "$(grep -vc '^#\|^t_s' felt.csv)" 2000
felt=$(awk -F, 'NR > 1 && !/^#/ && ($21 != 0 || $22 != 0 || $23 != 0) { n++ } END { print n + 0 }' felt.csv)
[ "$felt" -gt 100 ] || fail "$felt ticks with a force, expected more than 100"
run 0 replay felt.session --json
check "removed voxels in the table and in a replay" "$(awk -F, 'NR > 1 && !/^#/ { n += $14 } END { print n + 0 }' felt.csv)" "$(value removed_voxels)"

# The table must begin with the columns of the path.
run 0 export early.session --out table.csv
awk -F, 'NR > 1 && !/^#/ { print $1 + 0, $2 + 0, $4 + 0, $9 }' table.csv >got
printf '%s\n' "-0.5 0 0 0" "-0.25 0 1 1" "0.125 0 2 0" >expected
cmp -s got expected || fail "the columns of the path differ from the recorded path: $(cat got)"

for kind in mcap h5 hdf5; do
    refuse 2 "export the session to a table, --out FILE.csv" export felt.session --out x.$kind
    [ ! -e x.$kind ] || fail "a refused export left x.$kind"
done
refuse 2 "not a session" export bone.nrrd --out x.csv
refuse 2 "cannot write:" export felt.session --out nowhere/x.csv
[ ! -e x.csv ] || fail "a refused export left x.csv"
finish
