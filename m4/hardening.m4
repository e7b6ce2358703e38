# SPDX-License-Identifier: Apache-2.0
#
# OST_HARDENING: flags of compiler and linker that limit the consequences of a
# memory error, unless --disable-hardening is given.  Each flag is used if this
# toolchain supports it.  None changes a result.
#   -D_FORTIFY_SOURCE=3 (or 2)  libc checks sizes of buffers; needs -O
#   -fstack-protector-strong    a canary after arrays on the stack; not used for
#                               the files of an instruction set, because their
#                               loops use arrays of vectors (OST_KERNEL_CFLAGS)
#   -fcf-protection, -mbranch-protection=standard  checks the targets of jumps
#                               on x86 and ARM
#   -fPIE, -pie                 loads the program at a random address
#   -z relro, now, noexecstack  the table of addresses is not writable, and the
#                               stack is not executable
# Fortified functions hide errors from AddressSanitizer, so that flag is omitted
# with --enable-sanitize.  Sets OST_HARD_CFLAGS, OST_HARD_LDFLAGS,
# OST_KERNEL_CFLAGS, OST_PIE_LDFLAGS.
AC_DEFUN([OST_HARD_FLAG], [
  AS_VAR_PUSHDEF([ost_var], [ost_cv_hard_$1])
  AC_CACHE_CHECK([whether $CC takes $1], [ost_var], [
    ost_save_CFLAGS=$CFLAGS
    CFLAGS="$CFLAGS $1 -Werror"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <string.h>]], [[char a[8]; memset(a, 1, sizeof a); return a[0] - 1;]])],
      [AS_VAR_SET([ost_var], [yes])], [AS_VAR_SET([ost_var], [no])])
    CFLAGS=$ost_save_CFLAGS])
  AS_VAR_IF([ost_var], [yes], [$2], [$3])
  AS_VAR_POPDEF([ost_var])
])

AC_DEFUN([OST_HARDENING], [
  AC_REQUIRE([AC_CANONICAL_HOST])
  AC_ARG_ENABLE([hardening], [AS_HELP_STRING([--disable-hardening],
    [no FORTIFY, stack protector, RELRO, PIE and control-flow protection])], [], [enable_hardening=yes])
  OST_HARD_CFLAGS=
  OST_HARD_LDFLAGS=
  OST_PIE_LDFLAGS=
  OST_KERNEL_CFLAGS=
  ost_summary_HARDENING=
  AS_IF([test "x$enable_hardening" != xno], [
    ost_level=
    for ost_flag in $CFLAGS; do
      AS_CASE([$ost_flag], [-O*], [ost_level=$ost_flag])
    done
    ost_fortify=no
    AS_CASE(["$ost_level $enable_sanitize $CPPFLAGS $CFLAGS"],
      [*_FORTIFY_SOURCE*], [ost_summary_HARDENING=" FORTIFY (the user's)"],
      [-O0\ *|-Og\ *|\ *], [],
      [*\ no\ *], [
        OST_HARD_FLAG([-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3], [ost_fortify=3],
          [OST_HARD_FLAG([-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2], [ost_fortify=2])])])
    AS_IF([test $ost_fortify != no], [
      OST_HARD_CFLAGS="-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=$ost_fortify"
      ost_summary_HARDENING=" FORTIFY=$ost_fortify"])
    OST_HARD_FLAG([-fstack-protector-strong], [
      OST_HARD_CFLAGS="$OST_HARD_CFLAGS -fstack-protector-strong"
      OST_KERNEL_CFLAGS=-fno-stack-protector
      ost_summary_HARDENING="$ost_summary_HARDENING stack-protector"])
    AS_CASE([$host_cpu],
      [x86_64|i?86], [OST_HARD_FLAG([-fcf-protection], [
        OST_HARD_CFLAGS="$OST_HARD_CFLAGS -fcf-protection"
        ost_summary_HARDENING="$ost_summary_HARDENING CET"])],
      [aarch64*], [OST_HARD_FLAG([-mbranch-protection=standard], [
        OST_HARD_CFLAGS="$OST_HARD_CFLAGS -mbranch-protection=standard"
        ost_summary_HARDENING="$ost_summary_HARDENING branch-protection"])])
    OST_HARD_FLAG([-fPIE -pie], [
      OST_HARD_CFLAGS="$OST_HARD_CFLAGS -fPIE"
      OST_PIE_LDFLAGS=-pie
      ost_summary_HARDENING="$ost_summary_HARDENING PIE"])
    OST_HARD_FLAG([-Wl,-z,relro,-z,now], [
      OST_HARD_LDFLAGS=-Wl,-z,relro,-z,now
      ost_summary_HARDENING="$ost_summary_HARDENING RELRO"])
    OST_HARD_FLAG([-Wl,-z,noexecstack], [
      OST_HARD_LDFLAGS="$OST_HARD_LDFLAGS -Wl,-z,noexecstack"
      ost_summary_HARDENING="$ost_summary_HARDENING noexecstack"])])
  ost_summary_HARDENING=`echo ${ost_summary_HARDENING:-no}`
  AC_SUBST([OST_HARD_CFLAGS])
  AC_SUBST([OST_HARD_LDFLAGS])
  AC_SUBST([OST_KERNEL_CFLAGS])
  AC_SUBST([OST_PIE_LDFLAGS])
  AC_SUBST([ost_summary_HARDENING])
])
