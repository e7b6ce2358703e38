# SPDX-License-Identifier: Apache-2.0
#
# Options for developers of osteon.

# OST_WARNINGS: enables each of these warnings that the compiler supports, and
# makes them errors with --enable-werror, for CI.  Intentionally not used:
# -Wconversion (the many casts that it requires would hide the range proofs next
# to the arithmetic), -Wpadded, -Wdeclaration-after-statement.
AC_DEFUN([OST_WARNINGS], [
  AC_ARG_ENABLE([werror], [AS_HELP_STRING([--enable-werror], [warnings are errors (for CI)])], [], [enable_werror=no])
  OST_WARN_CFLAGS=
  for ost_w in -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wold-style-definition \
      -Wpointer-arith -Wcast-qual -Wwrite-strings -Wundef -Wvla -Wformat=2 -Wswitch-enum -Wimplicit-fallthrough; do
    AC_MSG_CHECKING([whether $CC takes $ost_w])
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS $ost_w -Werror"
    AC_COMPILE_IFELSE([AC_LANG_PROGRAM([], [])],
      [AC_MSG_RESULT([yes]); OST_WARN_CFLAGS="$OST_WARN_CFLAGS $ost_w"], [AC_MSG_RESULT([no])])
    CFLAGS=$ost_save_CFLAGS
  done
  ost_summary_WERROR="on, not errors (--enable-werror makes them so)"
  AS_IF([test "x$enable_werror" = xyes],
    [OST_WARN_CFLAGS="$OST_WARN_CFLAGS -Werror"; ost_summary_WERROR="errors"])
  AC_SUBST([OST_WARN_CFLAGS])
  # Every C++ compiler supports these.
  OST_WARN_CXXFLAGS="-Wall -Wextra -Wshadow"
  AS_IF([test "x$enable_werror" = xyes], [OST_WARN_CXXFLAGS="$OST_WARN_CXXFLAGS -Werror"])
  AC_SUBST([OST_WARN_CXXFLAGS])
])

# OST_SANITIZE: the option --enable-sanitize=LIST, such as address,undefined.
AC_DEFUN([OST_SANITIZE], [
  AC_ARG_ENABLE([sanitize], [AS_HELP_STRING([--enable-sanitize@<:@=LIST@:>@], [build with these sanitizers (default list: address,undefined,float-cast-overflow)])],
    [], [enable_sanitize=no])
  OST_SAN_CFLAGS=
  ost_summary_SANITIZE="no"
  AS_IF([test "x$enable_sanitize" = xyes], [enable_sanitize=address,undefined,float-cast-overflow])
  AS_IF([test "x$enable_sanitize" != xno], [
    OST_SAN_CFLAGS="-fsanitize=$enable_sanitize -fno-sanitize-recover=all -fno-omit-frame-pointer -g"
    ost_summary_SANITIZE="$enable_sanitize"])
  AC_SUBST([OST_SAN_CFLAGS])
])

# OST_FUZZ: with --enable-fuzz (clang), the targets of tests/fuzz are linked to
# libFuzzer.  Without it, the same sources are tests of make check that replay
# inputs.
AC_DEFUN([OST_FUZZ], [
  AC_ARG_ENABLE([fuzz], [AS_HELP_STRING([--enable-fuzz], [link the fuzz targets to libFuzzer (clang)])], [], [enable_fuzz=no])
  OST_FUZZ_CFLAGS=
  ost_summary_FUZZ="replays only (--enable-fuzz links them to libFuzzer)"
  AS_IF([test "x$enable_fuzz" = xyes], [
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS -fsanitize=fuzzer-no-link"
    AC_COMPILE_IFELSE([AC_LANG_PROGRAM([], [])], [],
      [AC_MSG_ERROR([--enable-fuzz needs clang with libFuzzer; Debian: clang and libclang-rt-*-dev])])
    CFLAGS=$ost_save_CFLAGS
    OST_FUZZ_CFLAGS="-fsanitize=fuzzer"
    OST_SAN_CFLAGS="$OST_SAN_CFLAGS -fsanitize=fuzzer-no-link"
    ost_summary_FUZZ="libFuzzer"])
  AC_SUBST([OST_FUZZ_CFLAGS])
  AM_CONDITIONAL([FUZZ], [test "x$enable_fuzz" = xyes])
])
