#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim --headset with a runtime for tests (tests/headset/runtime.h): frames, the
# controller as the device, and one line with exit status 3 if something is missing.
# Covers: REQ-HEADSET
. "${srcdir:-.}/tests/app/lib.sh"

# Options that a headset does not support are refused before anything is opened.
refuse 2 "a headset needs gl" sim --headset --renderer points
refuse 2 "a headset's frames are not written" sim --headset --hud
refuse 2 "a headset needs the clock" sim --headset --no-clock
refuse 2 "pass --headset" sim --headless --bone builtin:glenoid --device openxr --seconds 0.1

if ! grep -q "^#define HAVE_OPENXR 1" "$build/config.h" || ! grep -q "^#define HAVE_GL 1" "$build/config.h"; then
    refuse 3 "install libopenxr-dev and libepoxy-dev" sim --headset --seconds 0.1
    finish
    exit
fi
XR_RUNTIME_JSON=$scratch/none.json
export XR_RUNTIME_JSON
refuse 3 "no OpenXR runtime is active" sim --headset --seconds 0.1

[ -e "$build/.libs/fake_openxr.so" ] && [ -z "${OST_SAN_CFLAGS:-}" ] || { finish; exit; }
printf '{"file_format_version": "1.0.0", "runtime": {"library_path": "%s"}}\n' "$build/.libs/fake_openxr.so" >runtime.json
XR_RUNTIME_JSON=$scratch/runtime.json
"$osteon" sim --headset --bone builtin:glenoid --seconds 0.1 >out 2>err
if [ $? -eq 3 ] && grep -q "EGL\|OpenGL" err; then
    echo "# without OpenGL, frames are not tested: $(cat err)"
    finish
    exit
fi

run 0 sim --headset --bone builtin:glenoid --seconds 1 --record own.session --json
check "names of the runtime and of the headset" "$(value headset.runtime), $(value headset.system)" "fake 1.2.3, a headset for tests"
check "size of an eye's picture in pixels" "$(value headset.width) x $(value headset.height)" "160 x 120"
check "name of the device" "$(value device)" openxr
check "number of ticks" "$(value ticks)" 1000
frames=$(value headset.frames)
[ "$frames" -ge 5 ] || fail "$frames frames in a second, expected at least 5"
check "frames without a pose" "$(value headset.frames_without_pose)" 0
# Tracking of the controller begins with the first frame, which may be later than the first tick.
[ "$(value dropouts)" -le 1 ] || fail "$(value dropouts) drop-outs, expected at most 1"
run 0 replay own.session --verify

# Tests another device, and the left hand.
run 0 sim --headset --bone builtin:glenoid --seconds 0.2 --device sim --json
check "name of the device with --device sim" "$(value device)" sim
run 0 sim --headset --bone builtin:glenoid --seconds 0.2 --device openxr:hand=left --json
refuse 2 "expected left or right" sim --headset --bone builtin:glenoid --device openxr:hand=both
finish
