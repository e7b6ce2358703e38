/* SPDX-License-Identifier: Apache-2.0 */
#include "app/devices/devices.h"

#include "config.h"

#include <stdio.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "render/gl/gl.h"
#include "window/window.h"

/* Opens OpenGL briefly and prints its version and driver, or the reason why OpenGL cannot be used. */
static void list_gl(const app_state *app, json_t *array)
{
    ost_gl *gl = NULL;
    ost_error why = {0};
    char text[OST_ERROR_TEXT];
    const bool there = !ost_gl_missing() && ost_gl_open(NULL, &gl, &why) == OST_OK;
    if (there) {
        const ost_gl_info info = ost_gl_info_get(gl);
        snprintf(text, sizeof text, "--renderer gl: OpenGL %s, %s, %s%s", info.version, info.driver, info.way,
                 info.software ? "; software: --renderer points is faster" : "");
    } else {
        snprintf(text, sizeof text, "%s", ost_gl_missing() ? ost_gl_missing() : why.text);
    }
    devices_put(app, array, "gl", there, text);
    ost_gl_close(gl);
}

void devices_list_libraries(const app_state *app)
{
    json_t *array = json_array();
    print_line(app, "%s", "");
    print_line(app, "optional parts");
#ifdef HAVE_ASSIMP
    devices_put(app, array, "assimp", true, "meshes: STL, OBJ, PLY, 3DS");
#else
    devices_put(app, array, "assimp", false, "meshes cannot be read; install libassimp-dev and build again");
#endif
#ifdef HAVE_NIFTI
    devices_put(app, array, "nifti", true, "NIfTI volumes: .nii, .nii.gz");
#else
    devices_put(app, array, "nifti", false, "NIfTI volumes cannot be read; install libnifti-dev and build again");
#endif
#ifdef HAVE_PNG
    devices_put(app, array, "png", true, "pictures: export to .png, diff --html; stacks of PNG slices");
#else
    devices_put(app, array, "png", false, "no pictures, no stacks of PNG slices; install libpng-dev and build again");
#endif
#ifdef HAVE_TIFF
    devices_put(app, array, "tiff", true, "stacks of TIFF slices");
#else
    devices_put(app, array, "tiff", false, "stacks of TIFF slices cannot be read; install libtiff-dev and build again");
#endif
    list_gl(app, array);
    const char *missing = ost_window_missing();
    devices_put(app, array, "window", missing == NULL, missing ? missing : "the simulator's window: osteon sim");
#ifdef HAVE_LIBWEBSOCKETS
    devices_put(app, array, "websockets", true, "--device inverse3: Haply's service");
#else
    devices_put(app, array, "websockets", false, "no --device inverse3; install libwebsockets-dev and build again");
#endif
#if defined HAVE_EMBREE4 || defined HAVE_EMBREE3
    devices_put(app, array, "embree", true, "--backend cpu:voxelizer=embree, and Embree's rows in osteon bench");
#else
    devices_put(app, array, "embree", false,
        "no --backend cpu:voxelizer=embree (same grids without); install libembree-dev and build again");
#endif
    put(app->result, "libraries", array);
}
