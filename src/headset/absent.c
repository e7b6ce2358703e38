/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the functions of headset.h in a build without OpenXR or OpenGL, in which a headset is never available. */
#include "headset/headset.h"

ost_status ost_headset_open(ost_headset **out, ost_error *err)
{
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "osteon was built without OpenXR; Debian: install libopenxr-dev and libepoxy-dev, and build again");
}

ost_status ost_headset_begin(ost_headset *headset, ost_gl *gl, int width, int height, bool left, ost_error *err)
{
    (void)headset;
    (void)gl;
    (void)width;
    (void)height;
    (void)left;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without OpenXR");
}

ost_headset_info ost_headset_info_get(const ost_headset *headset)
{
    (void)headset;
    return (ost_headset_info){.width = 0};
}

ost_status ost_headset_frame(ost_headset *headset, const ost_headset_calls *calls, bool *ended, ost_error *err)
{
    (void)headset;
    (void)calls;
    *ended = true;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without OpenXR");
}

ost_headset_counts ost_headset_counts_get(const ost_headset *headset)
{
    (void)headset;
    return (ost_headset_counts){0};
}

void ost_headset_end(ost_headset *headset)
{
    (void)headset;
}

void ost_headset_close(ost_headset *headset)
{
    (void)headset;
}
