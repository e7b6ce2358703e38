# SPDX-License-Identifier: Apache-2.0
#
# OST_BENCH_FLAGS: how the baselines of `osteon bench` are compiled.  They are
# part of the command, so a package for other machines than the one that builds
# it says --disable-native-bench; the command itself notices at run time when
# the processor lacks what they were built for.  Sets BENCH_CFLAGS.
AC_DEFUN([OST_BENCH_FLAGS], [
  AC_ARG_ENABLE([native-bench], [AS_HELP_STRING([--disable-native-bench],
    [compile the baselines of osteon bench for any processor, not for this one])],
    [], [enable_native_bench=auto])
  AS_IF([test "x$enable_native_bench" = xauto && test "x$cross_compiling" = xyes], [enable_native_bench=no])
  BENCH_CFLAGS="-O3"
  AS_IF([test "x$enable_native_bench" != xno], [
    AC_MSG_CHECKING([whether $CC takes -march=native])
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS -march=native -Werror"
    AC_COMPILE_IFELSE([AC_LANG_PROGRAM([], [])], [BENCH_CFLAGS="-O3 -march=native"; ost_bench=yes], [ost_bench=no])
    CFLAGS=$ost_save_CFLAGS
    AC_MSG_RESULT([$ost_bench])
    AS_IF([test "x$enable_native_bench" = xyes && test "x$ost_bench" = xno],
      [AC_MSG_ERROR([--enable-native-bench was asked for, but $CC does not take -march=native])])])
  AC_SUBST([BENCH_CFLAGS])
  AC_DEFINE_UNQUOTED([OST_BENCH_CFLAGS], ["$BENCH_CFLAGS"], [How the baselines of osteon bench are compiled.])
])
