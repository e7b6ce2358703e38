/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon info`.
 *
 *   cmd_info.c    parses the options, finds the kind of the file and calls the function of this kind
 *   geometry.c    prints the facts that all volumes have
 *   volume.c      a volume with a header: NRRD, NIfTI, MetaImage
 *   ct.c          a CT without a header: a text file, a stack of slices
 *   dicom.c       a folder of DICOM files
 *   mesh.c        a mesh
 *   path.c        a path
 *
 * app/replay/session_info.h describes sessions.
 */
#ifndef OST_APP_INFO_INFO_H
#define OST_APP_INFO_INFO_H

#include "app/input/load.h"

/* Prints the dimensions, the spacing and the position of a grid, and stores them in the result of the verb. */
void info_put_geometry(const app_state *app, const ost_geometry *g);
/* Prints the entries of a header, and stores them in the result of the verb. */
void info_print_meta(const app_state *app, const ost_meta *meta);

/*
 * Describes a volume by its header. `format` is the name of the file format. If `digest` is true, also reads the
 * voxels, and prints the number of solid voxels and the digest of the grid.
 */
ost_status info_volume(const app_state *app, const char *name, const char *format, bool digest, ost_error *err);
/* Sets the facts of --set in the header of a bone or CT. The voxels are not changed. */
ost_status info_set_facts(const app_state *app, const char *name, ost_file_kind kind, const option_list *sets,
                          ost_error *err);

/*
 * Describes a CT given as text. Such a file has no header, so the complete file is read, and its voxels are
 * discarded.
 */
ost_status info_text(const app_state *app, const char *name, ost_error *err);
/* Describes a stack of slices. Such a stack states neither spacing nor position. */
ost_status info_stack(const app_state *app, const char *name, ost_error *err);

/* Lists the series of a DICOM folder, and describes the series that would be read. */
ost_status info_folder(const app_state *app, const char *name, const dicom_options *dicom, bool digest, ost_error *err);

/* Describes a mesh. Its lengths are printed in the unit of the file. */
ost_status info_mesh(const app_state *app, const char *name, ost_error *err);
/* Describes a path: its ticks, its duration, its tools and its gaps. */
ost_status info_path(const app_state *app, const char *name, ost_error *err);

#endif
