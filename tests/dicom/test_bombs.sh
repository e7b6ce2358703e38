#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests files that need far more memory or time than their size suggests. The import must end soon with status 2 and
# one line, and the process that parses the file must never have more memory than its limit.
# Covers: REQ-DICOM-CHILD
. "${srcdir:-.}/tests/dicom/lib.sh"

# refuses FAULT SLICE WORD...: checks that the import of a series ends within 60 s with status 2 and the documented line
# about a slice
refuses() {
    fault=$1
    file=$(slice_file "$2")
    shift 2
    rm -rf ct
    series ct "$@" || return
    [ "$(cat ct/* | wc -c)" -lt 5000000 ] || fail "$*: the files of the series have 5 MB or more"
    checks=$((checks + 3))
    timeout 60 "$osteon" import ct --out bone.nrrd >out 2>err </dev/null
    check "$*: status" $? 2
    check "$*: lines" "$(wc -l <err | tr -d ' ')" 1
    documented "$fault"
    grep -q "ct/$file: " err || fail "$*: '$(cat err)' does not name $file"
    [ ! -e bone.nrrd ] || fail "$*: a bone was written"
}

# Tests a data set of 2.25 GiB of zeros, deflated to 2.4 MB. It is skipped in builds with sanitizers, because the memory
# of the parser is not limited there.
[ -n "${OST_SAN_CFLAGS:-}" ] || refuses 'the parser needs too much memory' 1 dims=8,6,2 syntax=deflated bomb=1:9
# Tests a file with 200,000 nested sequences after the pixels.
refuses 'a file that is truncated or damaged, or an image without pixels' 1 dims=8,6,2 'append=1:fafffafffffffffffeff00e0ffffffff*200000'
finish
