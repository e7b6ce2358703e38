#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Exports a session to MCAP and HDF5. Each file is read by its specification alone and compared
# with the table, tick by tick, and by libhdf5 where it is installed.
# Covers: REQ-SESSION-EXPORT
. "${srcdir:-.}/tests/app/lib.sh"
if [ -z "${PYTHON3:-}" ] || [ "$PYTHON3" = no ]; then
    echo "skipped: no python3"
    exit 77
fi
tool="$PYTHON3 $source_folder/tests/app/export_tool.py"

run 0 phantom glenoid --spacing 1 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 sim --headless --no-clock --bone bone.nrrd --path builtin:glenoid-ream --seconds 2 --record felt.session
# Two tools, and a path that begins before time 0.
{ echo "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool"; echo "-0.5,0,0,0,1,0,0,0,0"; echo "-0.25,0,0,1,1,0,0,0,1"; echo "0.125,0,0,2,0.6,0,-0.8,0,0"; } >early.csv
run 0 ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path early.csv --out r.nrrd --record early.session

run 0 export felt.session --out felt.csv
for kind in mcap h5; do
    run 0 export felt.session --out felt.$kind --json
    has file_sha256 ticks
    first=$(value file_sha256)
    run 0 export felt.session --out again.$kind --json
    check "the same bytes again, $kind" "$(value file_sha256)" "$first"
done
felt=$(awk -F, 'NR > 1 && ($17 == 1 || $21 != 0 || $22 != 0 || $23 != 0 || $24 != 0 || $25 != 0 || $26 != 0) { n++ } END { print n + 0 }' felt.csv)
[ "$felt" -gt 100 ] || fail "hardly any force: $felt"
check "MCAP" "$($tool mcap felt.mcap felt.csv)" "2000 ticks, $felt forces"
check "HDF5" "$($tool hdf5 felt.h5 felt.csv)" "2000 ticks, $felt forces"

# The removed voxels are those in which the two bones differ, each listed once.
run 0 export felt.session --voxels --out voxels.h5 --json
voxels=$(value removed_voxels)
run 0 replay felt.session --out reamed.nrrd --json
check "as many as a replay removes" "$(value removed_voxels)" "$voxels"
check "which went" "$($tool voxels voxels.h5 bone.nrrd reamed.nrrd)" "$voxels voxels"
refuse 2 "--voxels is for .h5" export felt.session --voxels --out x.csv

run 0 export early.session --out early.csv
run 0 export early.session --out early.hdf5
check "HDF5 without a force" "$($tool hdf5 early.hdf5 early.csv)" "3 ticks, 0 forces"
run 0 export early.session --out early.mcap
"$PYTHON3" - "$source_folder" <<'END' || fail "times before nought"
import sys
sys.argv = ["export_tool.py", "mcap", "early.mcap", "early.csv"] + sys.argv[1:]
text = open(sys.argv[4] + "/tests/app/export_tool.py").read().rsplit("main()", 1)[0]
names = {}
exec(text, names)
_, _, messages, metadata = names["mcap"]("early.mcap")
assert metadata["mcap.time_shift_ns"] == "500000000", metadata
assert sorted({t for _, t, _ in messages}) == [0, 250000000, 625000000], messages
END

# A changed byte that a reader might not notice is detected by a CRC.
"$PYTHON3" - <<'END'
data = bytearray(open("felt.mcap", "rb").read())
data[len(data) // 2] ^= 1
open("bad.mcap", "wb").write(data)
END
$tool mcap bad.mcap felt.csv >/dev/null 2>&1 && fail "a changed byte is not noticed"

if command -v h5dump >/dev/null 2>&1; then
    h5dump -d /physics_data/continuous_data/high_frequency_poses/drill_pose/pose -y -w 1 -m %.9f felt.h5 | tr -d ' ,' | grep -E '^-?[0-9]+\.[0-9]{9}$' >by_h5dump
    check "numbers by libhdf5" "$(wc -l <by_h5dump | tr -d ' ')" 14000
    check "the last pose by libhdf5" "$(tail -n 7 by_h5dump | head -n 3 | awk '{ printf "%.6f ", $1 * 1000 }')" \
        "$(tail -n 1 felt.csv | awk -F, '{ printf "%.6f %.6f %.6f ", $2, $3, $4 }')"
    h5dump -a /metadata_v3/voxel_volume/units early.hdf5 | grep -q "mm^3, millimeters cubed" || fail "units by libhdf5"
    h5dump early.hdf5 >/dev/null || fail "libhdf5 does not read all of it"
fi
refuse 2 "is no session" export bone.nrrd --out x.mcap
refuse 2 "cannot write there" export felt.session --out nowhere/x.h5
[ ! -e x.mcap ] || fail "a file of nothing"
finish
