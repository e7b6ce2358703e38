#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests plugins. A plugin that wraps the reference must give the reference's results through the
# interface. Invalid plugins must be refused, each with its own message. If a plugin crashes, only
# the current case may fail.
# Covers: REQ-PLUGIN
. "${srcdir:-.}/tests/app/lib.sh"

# mirror.so and other plugins are linked to the library.
LD_LIBRARY_PATH=$build/.libs${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
# A crash must end the process, so sanitizers must not handle it.
ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}handle_segv=0
export ASAN_OPTIONS
for file in mirror thesis_f32 broken_abi broken_size broken_slot broken_arithmetic broken_refuses old_table; do
    cp "$build/.libs/$file.so" . || {
        echo "skipped: the plugins are not built, because this build has no shared objects"
        exit 77
    }
done

# Plugins and options that must be refused, with the expected messages.
ream() {
    status=$1 text=$2
    shift 2
    refuse "$status" "$text" ream --bone builtin:glenoid --tool builtin:peg --path builtin:peg-hole --out x.nrrd "$@"
}
ream 2 "plugin:FILE.so" --backend plugin
ream 2 "plugin:FILE.so" --backend plugin:
ream 2 "none.so: cannot open: No such file" --backend plugin:none.so
ream 2 "not a file" --backend plugin:.
echo "not a library" >text.so
ream 2 "text.so: cannot be loaded" --backend plugin:text.so
ream 2 "has no symbol ost_plugin_entry" --backend "plugin:$(ls "$build"/.libs/libosteon.so)"
ream 2 "version 99 of the plugin interface" --backend plugin:broken_abi.so
ream 2 "has 40 bytes" --backend plugin:broken_size.so
ream 2 "slot collide of its table is NULL" --backend plugin:broken_slot.so
ream 2 "version 99 of docs/spec/arithmetic.md" --backend plugin:broken_arithmetic.so
ream 2 "does not support" --backend plugin:broken_refuses.so
ream 2 "xxxx" --backend plugin:mirror.so,break=options
ream 3 "but no object" --backend plugin:mirror.so,break=nothing
ream 2 "contract=on or contract=off" --backend plugin:thesis_f32.so,contract=maybe
[ ! -e x.nrrd ] || fail "a command with a refused plugin left an output"

# The reference as a plugin must equal the reference at every stage.
for case in import/1 mesh/1 sweep/1; do
    run 0 validate --only $case --backends plugin:mirror.so --json
    check "case $case: equal" "$(value equal)" true
done

# The same must be true if each stage receives the reference's grids.
run 0 compare plugin:mirror.so --only sweep/1 --apart

# check_failure WHAT TEXT CASE: checks that an error at run time is reported in a line with TEXT and fails
# only this case
check_failure() {
    run 1 validate --only "$3" --backends "plugin:mirror.so,break=$1" || return
    checks=$((checks + 1))
    grep -qF -- "$2" out || fail "$1: the output '$(cat out)' does not contain '$2'"
}
check_failure crash "ended by signal 11" sweep/1
check_failure status "remove returned 77, which is not a status" sweep/1
check_failure lost "the device?went away" sweep/1
check_failure report "reported chunk -3" sweep/1
check_failure stats "-1 active chunks" sweep/1
check_failure voxelize "but no object" mesh/1
# Steps that a plugin computes itself must be compared, and a wrong step must be named. A plugin
# with an older table has no slot for the steps and receives the host's steps.
check_failure snap "snap 0: mesh digest is" mesh/1
check_failure steps "steps 0: step yz (pose 1) is" sweep/1
run 0 validate --only sweep/1 --backends plugin:mirror.so
checks=$((checks + 2))
grep -q '^ *computed by the backend itself and compared: [0-9]* records of stages snap and steps$' out || fail "the output does not state that the plugin computed the steps: $(cat out)"
run 0 validate --only sweep/1 --backends plugin:old_table.so
grep -q '^ *supplied by src/core and not compared: sweep, map, boxes, poses and snapping$' out || fail "the output does not state that the host supplied the steps: $(cat out)"
refuse 2 "ended by signal 11" validate --only mesh/1 --backends plugin:mirror.so,break=open
refuse 2 "slot collide of its table is NULL" validate --only mesh/1 --backends plugin:broken_slot.so

# The example plugin, built as a user would build it, must behave like the one that make check
# built.
if [ "${MAKE:-}" ] && [ -z "${OST_SAN_CFLAGS:-}" ]; then
    cp -r "$source_folder/examples/plugin" example
    chmod -R u+w example
    checks=$((checks + 1))
    MAKEFLAGS='' MFLAGS='' "$MAKE" -s -C example CC="$CC" CPPFLAGS="-I$source_folder/include" >log 2>&1 || fail "the Makefile of the example plugin fails: $(tail -n 3 log)"
    run 1 validate --only import/1 --backends plugin:example/thesis_f32.so
    grep "import/1 on" out | sed 's/.*so: //' >differs
    run 1 validate --only import/1 --backends plugin:thesis_f32.so
    check "first difference of the two builds of the example plugin" "$(grep 'import/1 on' out | sed 's/.*so: //')" "$(cat differs)"
fi
finish
