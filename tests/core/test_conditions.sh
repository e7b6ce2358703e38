#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests that src/core/conditions.h compiles with the compiler of this build, and that it does not
# compile if one of its conditions is violated. To simulate a violation, the test defines the macro
# that such a compiler would define.
# Covers: AR-CC-1, AR-CC-2, AR-CC-3, AR-CC-4
. "${srcdir:-.}/tests/app/lib.sh"

# compiles STATUS WORDS OPTION...: compiles the header with the options. STATUS is yes or no; the
# compiler's output must contain WORDS.
compiles() {
    expected=$1
    words=$2
    shift 2
    echo '#include "core/conditions.h"' >unit.c
    # CC is not quoted, because it may contain a launcher or options.
    if ${CC:-cc} -std=c11 -I"$source_folder/src" "$@" -fsyntax-only unit.c >log 2>&1; then got=yes; else got=no; fi
    check "conditions.h with '$*' compiles" "$got" "$expected"
    checks=$((checks + 1))
    [ -z "$words" ] || grep -q "$words" log || fail "with '$*' the compiler does not report '$words': $(head -n 3 log)"
}

compiles yes ''
grep -q . log && fail "the compiler prints a warning although no condition is violated: $(head -n 3 log)"
compiles no 'little-endian' -U__BYTE_ORDER__ -D__BYTE_ORDER__=__ORDER_BIG_ENDIAN__
compiles no 'little-endian' -U__BYTE_ORDER__
compiles no 'fast-math' -ffast-math
compiles no 'fast-math' -ffinite-math-only
compiles no '8-bit bytes' -U__CHAR_BIT__ -D__CHAR_BIT__=16
compiles no 'excess precision' -U__FLT_EVAL_METHOD__ -D__FLT_EVAL_METHOD__=2
compiles no '128-bit integers' -D__int128=int
finish
