# SPDX-License-Identifier: Apache-2.0
#
# OST_BENCH_FLAGS: the flags with which the baselines of `osteon bench` are
# compiled.  The baselines are part of the command.  Therefore a package for
# machines other than the build machine needs --disable-native-bench.  At run
# time the command detects that the processor lacks an instruction set for
# which the baselines were built.  Sets BENCH_CFLAGS.
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
