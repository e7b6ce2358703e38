#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the debrief of the built-in operation. Its path reaches a depth of 22 mm with the peg and 3
# mm with the reamer, both along the phantom's own axis. The debrief must show these values, and its
# page must be complete and self-contained.
# Covers: REQ-METRICS, REQ-DEBRIEF
. "${srcdir:-.}/tests/app/lib.sh"

# near WHAT VALUE LO HI: checks that VALUE is within LO and HI
near() {
    checks=$((checks + 1))
    awk -v x="$2" -v lo="$3" -v hi="$4" 'BEGIN { exit !(x != "" && x >= lo && x <= hi) }' || fail "$1 is '$2', expected $3 to $4"
}

# Uses a complete scapula, because the scan of the glenoid ends before the end of the hole.
run 0 phantom scapula --spacing 1 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --tool builtin:reamer --path builtin:glenoid-ream --out reamed.nrrd \
    --record o.session --debrief o.html --json
cp out ream.json
check "the removed volumes of the metrics and of ream agree to 0.01 mm3" "$(awk -v a="$(value metrics.removed_mm3)" -v b="$(value removed_mm3)" 'BEGIN { print (a - b < 0.01 && b - a < 0.01) }')" 1
near "axis tilt, degrees" "$(value metrics.tilt_deg)" 0 0.1
near "displacement of the entry, mm" "$(value metrics.entry_mm)" 0 0.1
# The point of the path must be within half a voxel of the tool's lowest point.
near "depth reached, mm" "$(value metrics.reach_mm)" 2.7 3.3
near "depth at the centre, mm" "$(value metrics.centre_depth_mm)" 2.4 3.6
near "radius of the fitted sphere, mm" "$(value metrics.sphere_mm)" 25 29
near "mean depth, mm" "$(value metrics.depth_mean_mm)" 1 3.5
near "backing contact, percent" "$(value metrics.contact_percent)" 85 100
check "the metrics contain a hole" "$(value metrics.hole)" true
near "depth of the hole, mm" "$(value metrics.hole_depth_mm)" 21.5 22.5
near "angle of the hole, degrees" "$(value metrics.hole_angle_deg)" 0 0.1
near "displacement of the hole's entry, mm" "$(value metrics.hole_entry_mm)" 0 0.1
# The phantom's face is rotated 2 degrees backward and 5 degrees upward. Its seed varies both angles
# by up to 2 degrees. The landmarks of its frame deviate by a millimetre from the ideal positions.
near "planned version, degrees" "$(value metrics.version_planned_deg)" -1 5
near "planned inclination, degrees" "$(value metrics.inclination_planned_deg)" 2 9
near "difference of the reached and the planned version, degrees" "$(awk -v a="$(value metrics.version_deg)" -v b="$(value metrics.version_planned_deg)" 'BEGIN { print a - b }')" -2 2
near "width of the face before the operation, mm" "$(value metrics.width_before_mm)" 26 30
near "height of the face before the operation, mm" "$(value metrics.height_before_mm)" 35 41
# The paths have a length of 8 + 22 + 30 mm with the peg and 8 + 3 + 11 mm with the reamer, of which
# 22 mm and 3 mm are in bone.
near "length of the path, mm" "$(value metrics.technique.path_mm)" 81.9 82.1
near "length of the path in contact, mm" "$(value metrics.technique.contact_path_mm)" 24 25.6
check "contacts, passes, plunges" "$(value metrics.technique.contacts) $(value metrics.technique.passes) $(value metrics.technique.plunges)" "2 2 0"
check "last line of the page" "$(tail -n 1 o.html)" "</body></html>"
grep -q "Peg hole: depth" o.html || fail "the page does not contain the hole"
# The verdict must be first and agree with the numbers. Letters and a legend must show the
# orientation of the map.
verdict=$(printf 'As planned. Reamed %.1f mm deep of 3.0 planned, axis tilt 0.0 degrees, entry 0.0 mm off, over-reaming %.0f mm3, subchondral bone preserved %.0f %%, peg hole inside the bone.' \
    "$(value metrics.reach_mm)" "$(value metrics.over_mm3)" "$(value metrics.plate_kept_percent)")
check "the verdict" "$(value metrics.verdict)" "$verdict"
grep -qF "$verdict" o.html || fail "the page does not contain the verdict: $verdict"
check "the verdict is the first element of the page" "$(grep -n 'class="verdict\|<h1\|<table' o.html | head -n 1 | grep -c 'verdict good')" 1
grep -q '>P</text>.*>A</text>' o.html || fail "for a right shoulder, P is not left of A in the map"
grep -Eq '(src|href)="(http|/|[a-z]+\.)' o.html && fail "the page refers to other files"

# A replay must give the same values.
run 0 replay o.session --debrief r.html --json
for key in tilt_deg entry_mm verdict depth_mean_mm hole_depth_mm removed_mm3; do
    check "$key of a replay and of ream" "$(value metrics.$key)" "$("$json_get" metrics.$key <ream.json)"
done
# The session contains the plan, so the metrics can be computed again without options and without
# facts of the bone's file.
run 0 info o.session
check "number of keys of the plan in the session" "$(grep -c '^  plan\.\(at_mm\|axis\|side\|depth_mm\|trigonum_mm\|inferior_angle_mm\): ' out)" 6
LC_ALL=C sed '/^osteon_\(glenoid\|trigonum\|inferior\|side\)/d' bone.nrrd >plain.nrrd
path='--tool builtin:peg --path builtin:peg-hole --at -148.723,-18.868,54.133 --axis 0.817462,0.406924,-0.407639 --side right'
run 0 ream --bone plain.nrrd $path --planned 2.5 --out h.nrrd --record plain.session
run 0 replay plain.session --debrief r.html --json
check "metrics with the plan of the session: hole, planned depth" "$(value metrics.hole) $(value metrics.planned_mm)" "true 2.5"
run 0 replay plain.session --debrief r.html --planned 1 --json
check "planned depth if it is given by an option" "$(value metrics.planned_mm)" 1
run 0 replay o.session --debrief r.html --planned 1
grep -q "<b>&#10007; Off the plan: reamed 2.[0-9] mm too deep; up to 0.5 mm are allowed" r.html || fail "the page does not state that the reaming is too deep"
# Tests a session without a plan, recorded from a user's path on a bone without facts. The debrief
# must be refused unless options give the position and the axis of the glenoid.
run 0 export plain.session --out plain.csv
cut -d, -f1-9 <plain.csv >path.csv
run 0 ream --bone plain.nrrd --tool builtin:peg --path path.csv --out h.nrrd --record bare.session
run 0 info bare.session
grep -q plan out && fail "a session of a bone without facts contains a plan"
refuse 2 "the glenoid's position and axis are not set" replay bare.session --debrief x.html
run 0 replay bare.session --debrief r.html --at -148.723,-18.868,54.133 --axis 0.817462,0.406924,-0.407639 --side right
refuse 2 "--trigonum needs --inferior-angle as well" replay plain.session --debrief x.html --trigonum 1,2,3

# If the operation has a force, the page must show the force over time.
if [ "${OST_TEST_LONG:-0}" = 1 ]; then
    run 0 sim --headless --bone bone.nrrd --path builtin:glenoid-ream --seconds 2.5 --no-clock --record felt.session
    run 0 replay felt.session --debrief felt.html --planned 2
    grep -q "Hand force" felt.html || fail "the page does not contain the hand force"
    grep -q "direction\|floor" out || fail "the output for readers contains no metrics: $(cat out)"
fi
# Tests the debrief at the end of osteon sim, and of a run that continues a session. The plan of the
# second run must be that of the first run.
run 0 sim --headless --no-clock --device script --bone plain.nrrd $path --planned 2 --seconds 3 --record first.session
run 0 sim --headless --no-clock --device null --resume first.session --path builtin:peg-hole --seconds 0.01 --record second.session --debrief s.html --json
check "planned depth and page of osteon sim --debrief" "$(value metrics.planned_mm) $(value debrief)" "2 s.html"
seen=$(value metrics.removed_mm3)
run 0 replay second.session --debrief r.html --json
check "removed volume and planned depth of a run that continues the session" "$(value metrics.removed_mm3) $(value metrics.planned_mm)" "$seen 2"
refuse 2 "--debrief needs --record" sim --headless --bone plain.nrrd --debrief s.html
refuse 2 "must end in .html" replay o.session --debrief o.txt
refuse 2 "--planned 30: must be from 0 to 20" replay o.session --debrief x.html --planned 30
[ ! -e x.html ] || fail "a refused debrief left a page"
finish
