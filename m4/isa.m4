# SPDX-License-Identifier: Apache-2.0
#
# OST_ISA(VAR, flags, intrinsics): checks whether the compiler builds and links
# code for an instruction set.  Sets VAR_CFLAGS, the conditional BUILD_VAR, and
# HAVE_VAR_BUILD in config.h (0 or 1).  Only files that are named after the
# instruction set are compiled with these flags.  ISA_ALL_CPPFLAGS sets each
# HAVE_VAR_BUILD to 1, for kernels in portable C (tests/simd/portable).
AC_DEFUN([OST_ISA], [
  AC_CACHE_CHECK([whether $CC builds $1 code], [ost_cv_isa_$1], [
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS $2"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <immintrin.h>]], [[$3]])],
      [ost_cv_isa_$1=yes], [ost_cv_isa_$1=no])
    CFLAGS=$ost_save_CFLAGS])
  $1_CFLAGS=
  ost_isa_value=0
  AS_IF([test "x$ost_cv_isa_$1" = xyes], [$1_CFLAGS="$2"; ost_isa_value=1
    ost_summary_isa="$ost_summary_isa $1"])
  AC_SUBST([$1_CFLAGS])
  OST_ISA_BUILT([$1], [$ost_isa_value])
  AM_CONDITIONAL([BUILD_$1], [test "x$ost_cv_isa_$1" = xyes])
])

# OST_ISA_OPTIMISATION: the optimisation level of files that are named after an
# instruction set.  Sets ISA_OPT_CFLAGS, which comes after CFLAGS.
#   The loops in these files use arrays of two to four vectors.  The arrays are
# in registers only if the compiler unrolls the loops over them completely, and
# GCC does so with -O3.  Automake puts the user's CFLAGS last.  They usually
# contain -O2, the default of autoconf and of distributions, which would replace
# an earlier -O3.  The rule is:
#   -O2 (the last -O in CFLAGS)   is replaced by -O3 for these files
#   anything else                 is respected: -O0, -Og or -O1 for debugging,
#                                 -Os for size, or no -O
# CFLAGS on the command line of make replaces all these flags, as usual.
#   If the assembler supports it, branches are also placed so that they do not
# cross borders of 32 bytes.  Processors of the Skylake family decode such a
# branch again each time it is executed (Intel's erratum SKX102).  The position
# of a branch depends on all code before it in the library: without this option
# the loop over densities took either 26,000 or 19,500 cycles.
AC_DEFUN([OST_ISA_OPTIMISATION], [
  ost_level=
  for ost_flag in $CFLAGS; do
    AS_CASE([$ost_flag], [-O*], [ost_level=$ost_flag])
  done
  ISA_OPT_CFLAGS=
  AS_IF([test "x$ost_level" = x-O2], [ISA_OPT_CFLAGS=-O3
    AC_CACHE_CHECK([how branches keep off borders of 32 bytes], [ost_cv_isa_branches], [
      ost_cv_isa_branches=no
      ost_save_CFLAGS=$CFLAGS
      for ost_flag in -Wa,-mbranches-within-32B-boundaries -mbranches-within-32B-boundaries; do
        CFLAGS="$ost_save_CFLAGS -Werror $ost_flag"
        AC_COMPILE_IFELSE([AC_LANG_PROGRAM([], [])], [ost_cv_isa_branches=$ost_flag; break])
      done
      CFLAGS=$ost_save_CFLAGS])
    AS_IF([test "x$ost_cv_isa_branches" != xno], [ISA_OPT_CFLAGS="$ISA_OPT_CFLAGS $ost_cv_isa_branches"])])
  AC_SUBST([ISA_OPT_CFLAGS])
])

# OST_ISA_BUILT(VAR, value): defines HAVE_VAR_BUILD, unless it is defined on the command line.
AC_DEFUN([OST_ISA_BUILT], [
  AH_VERBATIM([HAVE_$1_BUILD], [/* 1 if $1 code is built. */
#ifndef HAVE_$1_BUILD
# undef HAVE_$1_BUILD
#endif])
  AC_DEFINE_UNQUOTED([HAVE_$1_BUILD], [$2])
  ISA_ALL_CPPFLAGS="$ISA_ALL_CPPFLAGS -DHAVE_$1_BUILD=1"
])

AC_DEFUN([OST_ISAS], [
  AC_REQUIRE([OST_ISA_OPTIMISATION])
  AC_SUBST([ISA_ALL_CPPFLAGS])
  ost_summary_isa="scalar"
  OST_ISA([AVX2], [-mavx2 -mbmi -mbmi2 -mlzcnt -mpopcnt],
    [__m256i a = _mm256_set1_epi8(1); return _mm256_movemask_epi8(a) + (int)_pext_u64(3, 1);])
  OST_ISA([AVX512], [-mavx2 -mbmi -mbmi2 -mlzcnt -mpopcnt -mavx512f -mavx512bw -mavx512dq -mavx512vl -mavx512cd],
    [__m512i a = _mm512_set1_epi16(1); return (int)_mm512_movepi16_mask(a);])
  OST_ISA([AVX512VBMI], [-mavx2 -mbmi -mbmi2 -mlzcnt -mpopcnt -mavx512f -mavx512bw -mavx512dq -mavx512vl -mavx512cd -mavx512vbmi],
    [__m512i a = _mm512_set1_epi8(1); a = _mm512_permutexvar_epi8(a, a); return (int)_mm512_movepi8_mask(a);])
  AC_MSG_CHECKING([for Advanced SIMD (NEON)])
  AC_COMPILE_IFELSE([AC_LANG_SOURCE([[
#if !defined __aarch64__
#error not AArch64
#endif
#include <arm_neon.h>
int32x4_t x;]])], [ost_neon=yes; ost_summary_isa="$ost_summary_isa NEON"], [ost_neon=no])
  AC_MSG_RESULT([$ost_neon])
  OST_ISA_BUILT([NEON], [`test "x$ost_neon" = xyes && echo 1 || echo 0`])
  AM_CONDITIONAL([BUILD_NEON], [test "x$ost_neon" = xyes])
])

# OST_OPENMP: threads of the CPU backend, optional.
AC_DEFUN([OST_OPENMP], [
  AC_ARG_WITH([openmp], [AS_HELP_STRING([--with-openmp], [use OpenMP: yes, no or auto (default)])],
    [], [with_openmp=auto])
  AS_CASE([$with_openmp], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-openmp takes yes, no or auto, not '$with_openmp'])])
  OPENMP_CFLAGS=
  ost_summary_OPENMP="no: the CPU backend uses one thread"
  AS_IF([test "x$with_openmp" != xno], [
    AC_MSG_CHECKING([for OpenMP])
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS -fopenmp"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <omp.h>]], [[return omp_get_max_threads();]])],
      [OPENMP_CFLAGS=-fopenmp; ost_summary_OPENMP=OpenMP])
    CFLAGS=$ost_save_CFLAGS
    AC_MSG_RESULT([${OPENMP_CFLAGS:-no}])
    AS_IF([test "x$with_openmp" = xyes && test "x$OPENMP_CFLAGS" = x],
      [AC_MSG_ERROR([--with-openmp was asked for, but $CC has none; Debian: gcc, or clang with libomp-dev])])])
  # Without OpenMP its pragmas have no effect, so no warning is needed.
  AS_IF([test "x$OPENMP_CFLAGS" = x], [OPENMP_CFLAGS=-Wno-unknown-pragmas])
  AC_SUBST([OPENMP_CFLAGS])
])
