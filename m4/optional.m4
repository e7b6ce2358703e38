# SPDX-License-Identifier: Apache-2.0
#
# OST_OPTIONAL_PKG(VAR, option, pkg-config spec, Debian package, effect of its absence)
#   With --with-option=auto (default), the library is used if it is found.  With
# yes, its absence is an error.  With no, it is not used.  Defines HAVE_VAR, sets
# VAR_CFLAGS, VAR_LIBS and ost_summary_VAR.
AC_DEFUN([OST_OPTIONAL_PKG], [
  AC_ARG_WITH([$2], [AS_HELP_STRING([--with-$2], [use $2: yes, no or auto (default)])],
    [], [with_$2=auto])
  AS_CASE([$with_$2], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-$2 takes yes, no or auto, not '$with_$2'])])
  have_$1=no
  ost_summary_$1="no (--without-$2): $5"
  AS_IF([test "x$with_$2" != xno], [
    PKG_CHECK_MODULES([$1], [$3], [have_$1=yes], [have_$1=no])
    AS_IF([test "x$have_$1" = xyes],
      [AC_DEFINE([HAVE_$1], [1], [Define if $2 is used.])
       ost_summary_$1="$2"],
      [ost_summary_$1="no: $5; Debian: $4"
       AS_IF([test "x$with_$2" = xyes],
         [AC_MSG_ERROR([--with-$2 was asked for, but $3 was not found; Debian: $4])])])])
  AM_CONDITIONAL([HAVE_$1], [test "x$have_$1" = xyes])
])

# OST_OPTIONAL_NIFTI: libnifti has no pkg-config file; its headers include each
# other without their folder, so the folder must be on the path.
AC_DEFUN([OST_OPTIONAL_NIFTI], [
  AC_ARG_WITH([nifti], [AS_HELP_STRING([--with-nifti], [use libnifti: yes, no or auto (default)])],
    [], [with_nifti=auto])
  AS_CASE([$with_nifti], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-nifti takes yes, no or auto, not '$with_nifti'])])
  AC_ARG_VAR([NIFTI_CFLAGS], [compiler flags for libnifti (default: -isystem /usr/include/nifti)])
  AC_ARG_VAR([NIFTI_LIBS], [linker flags for libnifti (default: -lnifti2 -lznz -lz)])
  have_NIFTI=no
  ost_summary_NIFTI="no (--without-nifti): NIfTI files cannot be read or written"
  AS_IF([test "x$with_nifti" != xno], [
    AS_IF([test "x$NIFTI_CFLAGS" = x], [
      for ost_dir in /usr/include/nifti /usr/local/include/nifti; do
        AS_IF([test -r $ost_dir/nifti2_io.h && test "x$NIFTI_CFLAGS" = x], [NIFTI_CFLAGS="-isystem $ost_dir"])
      done])
    AS_IF([test "x$NIFTI_LIBS" = x], [NIFTI_LIBS="-lnifti2 -lznz -lz -lm"])
    AC_MSG_CHECKING([for libnifti2])
    ost_save_LIBS=$LIBS
    ost_save_CPPFLAGS=$CPPFLAGS
    LIBS="$NIFTI_LIBS $LIBS"
    CPPFLAGS="$CPPFLAGS $NIFTI_CFLAGS"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <nifti2_io.h>]],
                                    [[nifti_image *n = nifti_image_read("x", 0); return n != 0;]])],
      [have_NIFTI=yes])
    AC_MSG_RESULT([$have_NIFTI])
    LIBS=$ost_save_LIBS
    CPPFLAGS=$ost_save_CPPFLAGS
    AS_IF([test "x$have_NIFTI" = xyes],
      [AC_DEFINE([HAVE_NIFTI], [1], [Define if libnifti is used.])
       ost_summary_NIFTI="libnifti (NIfTI-1 and -2)"],
      [NIFTI_CFLAGS=; NIFTI_LIBS=
       ost_summary_NIFTI="no: NIfTI files cannot be read or written; Debian: libnifti-dev"
       AS_IF([test "x$with_nifti" = xyes],
         [AC_MSG_ERROR([--with-nifti was asked for, but libnifti2 was not found; Debian: libnifti-dev])])])])
  AM_CONDITIONAL([HAVE_NIFTI], [test "x$have_NIFTI" = xyes])
])

# OST_OPTIONAL_EMBREE: Debian's Embree has no pkg-config file. 4 is preferred to 3.
AC_DEFUN([OST_OPTIONAL_EMBREE], [
  AC_ARG_WITH([embree], [AS_HELP_STRING([--with-embree], [use Embree 3 or 4: yes, no or auto (default)])],
    [], [with_embree=auto])
  AS_CASE([$with_embree], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-embree takes yes, no or auto, not '$with_embree'])])
  AC_ARG_VAR([EMBREE_CFLAGS], [compiler flags for Embree])
  AC_ARG_VAR([EMBREE_LIBS], [linker flags for Embree (default: -lembree4 or -lembree3)])
  have_EMBREE=no
  ost_summary_EMBREE="no (--without-embree): voxelizer=embree is not there"
  AS_IF([test "x$with_embree" != xno], [
    ost_given_EMBREE_LIBS=$EMBREE_LIBS
    for ost_version in 4 3; do
      AS_IF([test "x$have_EMBREE" = xno], [
        EMBREE_LIBS=${ost_given_EMBREE_LIBS:--lembree$ost_version}
        AC_MSG_CHECKING([for Embree $ost_version])
        ost_save_LIBS=$LIBS
        ost_save_CPPFLAGS=$CPPFLAGS
        LIBS="$EMBREE_LIBS $LIBS"
        CPPFLAGS="$CPPFLAGS $EMBREE_CFLAGS"
        AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <embree$ost_version/rtcore.h>]], [[return rtcNewDevice("") != 0;]])],
          [have_EMBREE=$ost_version])
        AC_MSG_RESULT([$have_EMBREE])
        LIBS=$ost_save_LIBS
        CPPFLAGS=$ost_save_CPPFLAGS])
    done
    AS_CASE([$have_EMBREE],
      [4], [AC_DEFINE([HAVE_EMBREE4], [1], [Define if Embree 4 is used.])],
      [3], [AC_DEFINE([HAVE_EMBREE3], [1], [Define if Embree 3 is used.])])
    AS_IF([test "x$have_EMBREE" != xno], [ost_summary_EMBREE="Embree $have_EMBREE"],
      [EMBREE_LIBS=$ost_given_EMBREE_LIBS
       ost_summary_EMBREE="no: voxelizer=embree is not there, nor Embree's rows in osteon bench; Debian: libembree-dev"
       AS_IF([test "x$with_embree" = xyes],
         [AC_MSG_ERROR([--with-embree was asked for, but neither Embree 4 nor 3 was found; Debian: libembree-dev])])])],
    [EMBREE_LIBS=])
  AM_CONDITIONAL([HAVE_EMBREE], [test "x$have_EMBREE" != xno])
])

# OST_OPTIONAL_OPENCL: found by pkg-config or, without it, in the system's default
# folders.  src/cl needs only OpenCL 1.2 of the loader.
AC_DEFUN([OST_OPTIONAL_OPENCL], [
  AC_ARG_WITH([opencl], [AS_HELP_STRING([--with-opencl], [use OpenCL 1.2: yes, no or auto (default)])],
    [], [with_opencl=auto])
  AS_CASE([$with_opencl], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-opencl takes yes, no or auto, not '$with_opencl'])])
  have_OPENCL=no
  ost_summary_OPENCL="no (--without-opencl): the backend cl is not there"
  AS_IF([test "x$with_opencl" != xno], [
    ost_given_OPENCL_LIBS=$OPENCL_LIBS
    PKG_CHECK_MODULES([OPENCL], [OpenCL >= 1.2], [],
      [OPENCL_LIBS=${ost_given_OPENCL_LIBS:--lOpenCL}])
    AC_MSG_CHECKING([for OpenCL 1.2's header and loader])
    ost_save_LIBS=$LIBS
    ost_save_CPPFLAGS=$CPPFLAGS
    LIBS="$OPENCL_LIBS $LIBS"
    CPPFLAGS="$CPPFLAGS $OPENCL_CFLAGS"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>]], [[return clGetPlatformIDs(0, 0, 0) + clEnqueueFillBuffer(0, 0, 0, 0, 0, 0, 0, 0, 0);]])],
      [have_OPENCL=yes])
    AC_MSG_RESULT([$have_OPENCL])
    LIBS=$ost_save_LIBS
    CPPFLAGS=$ost_save_CPPFLAGS
    AS_IF([test "x$have_OPENCL" = xyes],
      [AC_DEFINE([HAVE_OPENCL], [1], [Define if OpenCL is used.])
       ost_summary_OPENCL="OpenCL 1.2 (backend cl; devices: osteon devices)"],
      [OPENCL_CFLAGS=; OPENCL_LIBS=
       ost_summary_OPENCL="no: the backend cl is not there; Debian: ocl-icd-opencl-dev, opencl-headers"
       AS_IF([test "x$with_opencl" = xyes],
         [AC_MSG_ERROR([--with-opencl was asked for, but CL/cl.h or libOpenCL was not found; Debian: ocl-icd-opencl-dev, opencl-headers])])])],
    [OPENCL_CFLAGS=; OPENCL_LIBS=])
  AM_CONDITIONAL([HAVE_OPENCL], [test "x$have_OPENCL" = xyes])
])

# OST_OPTIONAL_DCMTK: for osteon-dicom, the program that parses DICOM. Its pkg-config file names all of
# DCMTK's libraries and requires the packages of libraries that are not used here, so the few that are
# needed are linked by name.
AC_DEFUN([OST_OPTIONAL_DCMTK], [
  AC_ARG_WITH([dcmtk], [AS_HELP_STRING([--with-dcmtk], [use DCMTK: yes, no or auto (default)])],
    [], [with_dcmtk=auto])
  AS_CASE([$with_dcmtk], [yes|no|auto], [],
    [AC_MSG_ERROR([--with-dcmtk takes yes, no or auto, not '$with_dcmtk'])])
  AC_ARG_VAR([DCMTK_CFLAGS], [compiler flags for DCMTK (default: -std=gnu++17, which its headers require)])
  AC_ARG_VAR([DCMTK_LIBS], [linker flags for DCMTK (default: -ldcmjpeg -ldcmjpls -ldcmimgle -ldcmdata -loflog -lofstd)])
  have_DCMTK=no
  ost_summary_DCMTK="no (--without-dcmtk): DICOM cannot be read"
  AS_IF([test "x$with_dcmtk" != xno && test "x$ost_cv_cxx_works" = xyes], [
    AS_IF([test "x$DCMTK_CFLAGS" = x], [DCMTK_CFLAGS=-std=gnu++17])
    AS_IF([test "x$DCMTK_LIBS" = x], [DCMTK_LIBS="-ldcmjpeg -ldcmjpls -ldcmimgle -ldcmdata -loflog -lofstd"])
    AC_MSG_CHECKING([for DCMTK 3.6.7 or later])
    AC_LANG_PUSH([C++])
    ost_save_LIBS=$LIBS
    ost_save_CPPFLAGS=$CPPFLAGS
    LIBS="$DCMTK_LIBS $LIBS"
    CPPFLAGS="$CPPFLAGS $DCMTK_CFLAGS"
    AC_LINK_IFELSE([AC_LANG_PROGRAM([[#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#if PACKAGE_VERSION_NUMBER < 367
#error DCMTK is older
#endif]], [[DcmFileFormat file;
DJDecoderRegistration::registerCodecs();
DJLSDecoderRegistration::registerCodecs();
DcmRLEDecoderRegistration::registerCodecs();
return file.loadFile("x").good();]])], [have_DCMTK=yes])
    LIBS=$ost_save_LIBS
    CPPFLAGS=$ost_save_CPPFLAGS
    AC_LANG_POP([C++])
    AC_MSG_RESULT([$have_DCMTK])
    AS_IF([test "x$have_DCMTK" = xyes],
      [AC_DEFINE([HAVE_DCMTK], [1], [Define if osteon-dicom is built.])
       ost_summary_DCMTK="DCMTK"],
      [DCMTK_CFLAGS=; DCMTK_LIBS=
       ost_summary_DCMTK="no: DICOM cannot be read; Debian: libdcmtk-dev, g++"
       AS_IF([test "x$with_dcmtk" = xyes],
         [AC_MSG_ERROR([--with-dcmtk was asked for, but DCMTK 3.6.7 was not found; Debian: libdcmtk-dev, g++])])])])
  AM_CONDITIONAL([HAVE_DCMTK], [test "x$have_DCMTK" = xyes])
  AS_IF([test "x$have_DCMTK" = xyes], [
    AS_IF([test "x$have_OPENJPEG" = xyes], [ost_summary_DCMTK="DCMTK, OpenJPEG"],
      [ost_summary_DCMTK="DCMTK; no JPEG 2000; Debian: libopenjp2-7-dev"])])
])
