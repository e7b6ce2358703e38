# SPDX-License-Identifier: Apache-2.0
#
# OST_CHECK_ARITHMETIC: checks the conditions of docs/spec/arithmetic.md section 2
# for the compiler and its flags.  Sets OST_ARITH_CFLAGS.  src/core/conditions.h
# asserts the same conditions at compile time, so that they are also checked in
# other build systems.
AC_DEFUN([OST_CHECK_ARITHMETIC], [
  AC_MSG_CHECKING([whether $CC takes -ffp-contract=off])
  ost_save_CFLAGS=$CFLAGS
  CFLAGS="$CFLAGS -ffp-contract=off -Werror"
  AC_COMPILE_IFELSE([AC_LANG_PROGRAM([], [])], [AC_MSG_RESULT([yes])],
    [AC_MSG_RESULT([no])
     AC_MSG_ERROR([the compiler must take -ffp-contract=off: a fused multiply-add changes host results])])
  CFLAGS=$ost_save_CFLAGS
  OST_ARITH_CFLAGS="-std=c11 -ffp-contract=off"
  AC_SUBST([OST_ARITH_CFLAGS])

  AC_MSG_CHECKING([for fast-math in CFLAGS or CPPFLAGS])
  AC_COMPILE_IFELSE([AC_LANG_SOURCE([[
#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__ > 0)
#error fast-math
#endif
int x;]])], [AC_MSG_RESULT([no])],
    [AC_MSG_RESULT([yes])
     AC_MSG_ERROR([-ffast-math, -Ofast and -ffinite-math-only break the arithmetic; remove them from CFLAGS])])
  # Parts of fast-math that set no macro of their own.
  for ost_flag in $CFLAGS $CPPFLAGS $LDFLAGS; do
    AS_CASE([$ost_flag],
      [-ffast-math|-Ofast|-funsafe-math-optimizations|-fassociative-math|-freciprocal-math|-ffp-contract=fast|-ffp-contract=on|-ftrapv|-mfpmath=*387*|-mdaz-ftz|-fshort-enums|-fpack-struct*],
      [AC_MSG_ERROR([$ost_flag breaks the arithmetic (docs/spec/arithmetic.md section 2); remove it])])
  done

  AC_MSG_CHECKING([that floats are evaluated in their own type (no x87)])
  AC_COMPILE_IFELSE([AC_LANG_SOURCE([[
#include <float.h>
#if FLT_EVAL_METHOD != 0
#error excess precision
#endif
int x;]])], [AC_MSG_RESULT([yes])],
    [AC_MSG_RESULT([no])
     AC_MSG_ERROR([FLT_EVAL_METHOD must be 0; on 32-bit x86 use -msse2 -mfpmath=sse, or build for a 64-bit machine])])

  AC_MSG_CHECKING([for 128-bit integers, 8-bit bytes and arithmetic right shift])
  AC_COMPILE_IFELSE([AC_LANG_SOURCE([[
#include <limits.h>
#include <stdint.h>
_Static_assert(CHAR_BIT == 8, "bytes");
_Static_assert(sizeof(__int128) == 16, "int128");
_Static_assert((-3 >> 1) == -2, "arithmetic shift");
_Static_assert((int16_t)(uint16_t)0xffff == -1, "two's complement");
int x;]])], [AC_MSG_RESULT([yes])],
    [AC_MSG_RESULT([no])
     AC_MSG_ERROR([the per-event map divides in 128 bits; gcc or clang on a 64-bit machine is needed])])

  AC_C_BIGENDIAN([AC_MSG_ERROR([a little-endian machine is needed: nothing here was ever checked on a big-endian one])])
])
