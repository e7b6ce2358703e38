#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Compares four reamings of the generated scapula: a good one, a tilted one, one that is too deep,
# and one with a displaced entry. The test makes the paths from a tilt, an offset and a depth, with
# and without rotation of the tool. The metrics must have these values, and the first line of the
# debrief must rank the operations.
# Covers: REQ-DEBRIEF-RANK
. "${srcdir:-.}/tests/app/lib.sh"

# near WHAT VALUE EXPECTED BOUND: checks that VALUE is within BOUND of EXPECTED
near() {
    checks=$((checks + 1))
    awk -v x="$2" -v e="$3" -v b="$4" 'BEGIN { d = x - e; exit !(x != "" && d <= b && d >= -b) }' || fail "$1 is '$2', expected $3 within $4"
}

# Reads the facts about the glenoid from the phantom's file.
at='-148.723 -18.868 54.133'
axis='0.817462 0.406924 -0.407639'
run 0 phantom scapula --spacing 1 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
grep -aq "osteon_glenoid_at_mm:=$at" bone.nrrd || fail "the bone's file does not contain the glenoid's position $at"

# reaming NAME TILT OFFSET DEPTH RPM: moves the tool's tip (z = 0) from 8 mm outside the face to
# DEPTH along a tilted axis. The axis is tilted about the direction in the face that is as superior
# as possible. Its entry is displaced from the centre by OFFSET mm in this direction.
reaming() {
    awk -v at="$at" -v axis="$axis" -v tilt="$2" -v off="$3" -v depth="$4" -v rpm="$5" '
    BEGIN {
        pi = atan2(0, -1); split(at, c, " "); split(axis, w, " ")
        n = sqrt(w[1]^2 + w[2]^2 + w[3]^2); for (i = 1; i <= 3; i++) w[i] /= n
        n = sqrt(w[1]^2 + w[2]^2); u[1] = -w[2] / n; u[2] = w[1] / n; u[3] = 0      # up x w
        v[1] = w[2] * u[3] - w[3] * u[2]; v[2] = w[3] * u[1] - w[1] * u[3]; v[3] = w[1] * u[2] - w[2] * u[1]
        t = tilt * pi / 180; for (i = 1; i <= 3; i++) a[i] = cos(t) * w[i] + sin(t) * u[i]
        n = sqrt(2 - 2 * a[3]); qw = (1 - a[3]) / n; qx = a[2] / n; qy = -a[1] / n   # takes -z to a
        print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
        for (k = 0; k <= (8 + depth) * 50; k++) {
            d = -8 + k / 50; h = k * 1e-3 * rpm / 60 * pi; s = sin(h); r = cos(h)
            printf "%.3f", k * 1e-3
            for (i = 1; i <= 3; i++) printf ",%.9f", c[i] + off * v[i] + d * a[i]
            printf ",%.10f,%.10f,%.10f,%.10f\n", qw * r, qx * r + qy * s, qy * r - qx * s, qw * s
        }
    }' >"$1.csv"
    run 0 ream --bone bone.nrrd --tool builtin:reamer --path "$1.csv" --out "$1.nrrd" --debrief "$1.html" --json
    cp out "$1.json"
}

reaming good 0 0 3 120
near "good reaming: tilt, degrees" "$(value metrics.tilt_deg)" 0 0.1
near "good reaming: displacement of the entry, mm" "$(value metrics.entry_mm)" 0 0.1
near "good reaming: depth, mm" "$(value metrics.reach_mm)" 3 0.1
near "good: over-reaming" "$(value metrics.over_mm3)" 0 1
reaming deep 0 0 12 120
near "deep reaming: depth, mm" "$(value metrics.reach_mm)" 12 0.1
# If the reamer of 36 mm were 8 mm deep in bone everywhere, it would remove 8 cm3; it removes less
# because the vault is narrower. Without a drill there is no hole.
near "deep reaming: over-reaming, mm3" "$(value metrics.over_mm3)" 4500 2500
check "deep reaming: the metrics contain a hole" "$(value metrics.hole)" false
check "deep reaming: plunges" "$(value metrics.technique.plunges)" 0
reaming beside 0 3 3 120
near "displaced reaming: tilt, degrees" "$(value metrics.tilt_deg)" 0 0.1
near "displaced reaming: displacement of the entry, mm" "$(value metrics.entry_mm)" 3 0.1
for rpm in 0 120; do
    reaming tilted 10 0 3 $rpm
    near "tilted reaming: tilt, degrees" "$(value metrics.tilt_deg)" 10 0.1
    near "tilted reaming: displacement of the entry, mm" "$(value metrics.entry_mm)" 0 0.1
    # For an upright scapula, this tilt would only change the version. Because of the scapula's
    # orientation, it also changes the inclination; the combination of both errors must be the tilt.
    near "tilted reaming: combined error of version and inclination, degrees" "$(awk -v a="$(value metrics.version_error_deg)" -v b="$(value metrics.inclination_error_deg)" 'BEGIN { print sqrt(a * a + b * b) }')" 10 0.5
    near "tilted reaming: planned version plus its error, degrees" "$(awk -v a="$(value metrics.version_planned_deg)" -v b="$(value metrics.version_error_deg)" 'BEGIN { print a + b }')" \
        "$(value metrics.version_deg)" 1e-4
    reaming both 6 2 3 $rpm
    near "tilted and displaced reaming: tilt, degrees" "$(value metrics.tilt_deg)" 6 0.1
    near "tilted and displaced reaming: displacement of the entry, mm" "$(value metrics.entry_mm)" 2 0.1
done

# The first line must be the same on the page and in the output for readers.
for name in good tilted deep; do
    first=$("$json_get" metrics.verdict <$name.json)
    checks=$((checks + 1))
    [ "$(sed -n '/<body>/,$p' $name.html | sed -n 2p | sed 's/<[^>]*>//g; s/&[^;]*; //')" = "$first" ] ||
        fail "$name.html begins with: $(sed -n '/<body>/,$p' $name.html | sed -n 2p)"
    echo "$name: $first"
done
check "grade of the good reaming" "$("$json_get" metrics.grade <good.json)" "As planned"
check "grade of the tilted reaming" "$("$json_get" metrics.grade <tilted.json)" "Off the plan"
check "grade of the deep reaming" "$("$json_get" metrics.grade <deep.json)" "Far off the plan"
"$json_get" metrics.verdict <tilted.json | grep -q "tilted by 10.0 degrees.*5.0 times the tolerance" || fail "the verdict does not state the tilt"
"$json_get" metrics.verdict <deep.json | grep -q "9.0 mm too deep.*18.0 times the tolerance" || fail "the verdict does not state the depth"
run 0 ream --bone bone.nrrd --tool builtin:reamer --path deep.csv --out x.nrrd --debrief x.html
grep -n "Far off the plan\|floor:\|version" out | head -n 1 | grep -q "Far off the plan" || fail "the verdict is not the first line of the output for readers: $(cat out)"
finish
