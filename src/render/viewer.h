/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A running operation as frames: the bone as it goes, the tool where it is.
 *
 *   ost_live --take--> surface of the bone --.
 *   tool volumes ----> surfaces of tools ----+--camera--> frame
 *   ost_live --state--> the tool's pose -----'
 *
 * One thread at a time.  A viewer that follows nothing shows what was set.
 */
#ifndef OST_RENDER_VIEWER_H
#define OST_RENDER_VIEWER_H

#include <osteon/live.h>
#include <osteon/tool.h>

#include "render/points/frame.h"

enum { OST_VIEWER_TOOLS = 16 };

typedef struct ost_viewer {
    ost_live *live;      /* borrowed; NULL: it follows nothing */
    ost_surface bone;
    ost_surface tool[OST_VIEWER_TOOLS];
    int tools;
    ost_isa isa;
    int threads;
    ost_style style;
    ost_frame frame;     /* of the last draw's size */
    ost_live_state state;
    bool has_state;      /* the tool is drawn where state says */
    uint64_t changed;    /* chunks that were taken */
} ost_viewer;

/* isa and threads as ost_points_options has them. */
ost_status ost_viewer_init(ost_viewer *viewer, const ost_geometry *bone, ost_style style, const char *isa, int threads, ost_error *err);
void ost_viewer_free(ost_viewer *viewer); /* also of a zeroed one */

/* In the order of the world's. */
ost_status ost_viewer_add_tool(ost_viewer *viewer, const ost_tool_volume *volume, ost_error *err);
/* From now on the bone is what live shows. */
void ost_viewer_follow(ost_viewer *viewer, ost_live *live);
/* What has changed since the last time. */
ost_status ost_viewer_update(ost_viewer *viewer, ost_error *err);
/* Into the frame, whose size is the camera's, which was checked. */
ost_status ost_viewer_draw(ost_viewer *viewer, const ost_camera *camera, ost_error *err);

#endif
