/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 07: draws a picture of a bone on which the surface of the cut is coloured
 * by depth.
 *
 *   07_picture BEFORE.nrrd AFTER.nrrd OUT.png
 *
 * The processor draws the picture, so neither a display nor a graphics driver is
 * needed.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_volume before, after;
    ost_picture picture;
    ost_view_options options;
    ost_glenoid glenoid;
    ost_status status;

    if (argc != 4) {
        fprintf(stderr, "usage: 07_picture BEFORE.nrrd AFTER.nrrd OUT.png\n");
        return 2;
    }
    memset(&before, 0, sizeof before);
    memset(&after, 0, sizeof after);
    memset(&picture, 0, sizeof picture);
    memset(&options, 0, sizeof options); /* 0 selects the default value of every option */

    status = ost_volume_read(argv[1], NULL, &before, NULL, &err);
    if (!status)
        status = ost_volume_read(argv[2], NULL, &after, NULL, &err);
    /* The camera views the glenoid en face, along the glenoid's axis, which is stored in the header of the bone's
       file. */
    if (!status)
        status = ost_glenoid_from_meta(&before.meta, &glenoid, &err);
    if (!status) {
        memcpy(options.direction, glenoid.axis, sizeof options.direction);
        options.width = options.height = 480;
        status = ost_picture_view(&after, &before, &options, &picture, &err);
    }
    if (!status)
        status = ost_picture_write_png(argv[3], &picture, &err);

    if (status)
        fprintf(stderr, "07_picture: %s\n", err.text);
    else
        printf("%d x %d pixels\n", picture.width, picture.height);
    ost_picture_free(&picture);
    ost_volume_free(&after);
    ost_volume_free(&before);
    return ost_status_exit(status);
}
