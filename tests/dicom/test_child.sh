#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Replaces the process that parses DICOM files by programs that fail in every way. The command must end soon with
# one line and no output, and no process may remain.
# Covers: REQ-DICOM-CHILD
. "${srcdir:-.}/tests/dicom/lib.sh"

series ct
mkdir lib
OSTEON_LIBEXECDIR=$scratch/lib
child=lib/osteon-dicom

# expect_failure TEXT COMMAND: replaces the process by a shell command and checks that the series is refused with a message
# that contains TEXT
expect_failure() {
    printf '#!/bin/sh\necho $$ >%s/pid\n%s\n' "$scratch" "$2" >$child
    chmod +x $child
    rm -f pid
    checks=$((checks + 3))
    timeout 100 "$osteon" import ct --out bone.nrrd >out 2>err </dev/null
    check "$2: status" $? 2
    check "$2: lines" "$(wc -l <err | tr -d ' ')" 1
    grep -q "$1" err || fail "$2: '$(cat err)' does not contain '$1'"
    [ ! -e bone.nrrd ] || fail "$2: a bone was written"
    [ ! -s pid ] || ! kill -0 "$(cat pid)" 2>/dev/null || fail "$2: the process still runs"
}

refuse 3 'osteon-dicom' import ct --out bone.nrrd
: >$child
refuse 3 'osteon-dicom' import ct --out bone.nrrd
expect_failure . 'exit 0'
expect_failure . 'exit 1'
expect_failure . 'kill -SEGV $$'
expect_failure . 'kill -KILL $$'
expect_failure . 'exec >&-; sleep 1'
expect_failure . 'echo hello'
expect_failure . 'cat /dev/zero'
expect_failure . 'cat /dev/urandom'
expect_failure . 'yes'
expect_failure . 'while :; do printf "\3\0\0\0\0\0\0\0\0\0\0\0"; done'           # END without an end
expect_failure . 'while :; do printf "\1\0\0\0\0\0\0\0\4\0\0\0\1\0\0\0"; done'    # FILE of the first path again and again
expect_failure . 'printf "\1\0\0\0\377\377\377\177\4\0\0\0\0\0\0\0"'              # FILE of a path that does not exist
expect_failure . 'printf "\1\0\0\0\0\0\0\0\4\0\0\0\377\377\377\377"'              # FILE with a result that does not exist
expect_failure . 'printf "\0\0\0\0\0\0\0\0\377\377\377\377"; cat /dev/zero'       # FRAME of 4 GB
expect_failure . 'printf "\2\0\0\0\0\0\0\0\377\377\377\177"; cat /dev/zero'       # PIXELS during a scan
expect_failure . 'printf "\1\0\0\0\0\0"'                                          # half a message
expect_failure . 'head -c 4000000000 /dev/zero >"$0.large"; exit 1'
checks=$((checks + 1))
[ ! -s $child.large ] || fail "the process wrote a file"
if [ -n "${OST_TEST_LONG:-}" ]; then
    expect_failure . 'sleep 1000'
    expect_failure . 'while :; do :; done'
fi
finish
