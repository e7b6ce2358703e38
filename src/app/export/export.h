/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon export`.
 *
 *   cmd_export.c   parses the options
 *   write.c        loads the bone, selects its voxels (parts.h) and writes them in the format of the extension
 *   surface.c      .stl .ply .obj
 *   picture.c      .png
 *
 * app/replay/session_info.h writes a session as a table.
 */
#ifndef OST_APP_EXPORT_EXPORT_H
#define OST_APP_EXPORT_EXPORT_H

#include "app/input/load.h"
#include "app/picture/view.h"

typedef struct export_args {
    const char *bone, *out, *before;
    bool slices, compress, labels, omit_empty;
    view_options view;
    int64_t threshold, decimals;
    bool threshold_given;
    target_options target;
} export_args;

/* Loads the bone, writes the file of --out and reports it. */
ost_status export_file(const app_state *app, const export_args *args, ost_error *err);

/* Extracts the surface of the volume as a closed mesh, and writes and reports the mesh. */
ost_status export_surface(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err);
/* Draws slices or, with --view, the surface, and writes and reports the picture. */
ost_status export_picture(const app_state *app, const export_args *args, loaded_volume *in, ost_error *err);

#endif
