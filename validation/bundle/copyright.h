/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the licence of an installed Debian package, as an SPDX expression:
 *
 *   /usr/share/doc/PACKAGE/copyright, in the machine-readable format 1.0
 *   --licence of "Files: *"--> "GPL-2+ and Expat" --> "GPL-2.0-or-later AND MIT"
 *
 * Other formats, other systems and names that have no SPDX identifier give "".
 */
#ifndef OST_VALIDATION_COPYRIGHT_H
#define OST_VALIDATION_COPYRIGHT_H

#include <osteon/status.h>

enum { COPYRIGHT_LICENCE = 200 };

/*
 * Finds the licence in the copyright file of a package. Writes "" if the package has no such file, or if the file
 * names no licence that this program recognises. A file that cannot be read is an error; otherwise, the lists of
 * software would depend on the permissions of files.
 */
ost_status copyright_of(const char *package, char out[COPYRIGHT_LICENCE], ost_error *err);

/*
 * Translates Debian's short names, joined by "and" and "or", into an SPDX expression. Writes "" if a name has no SPDX
 * identifier.
 */
void copyright_spdx(const char *debian, char out[COPYRIGHT_LICENCE]);

#endif
