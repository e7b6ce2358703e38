/* SPDX-License-Identifier: Apache-2.0 */
/* Allocates and frees the memory of a picture. */
#include <stdlib.h>
#include <string.h>

#include <osteon/picture.h>

enum { PICTURE_SIDE_MAX = 16384 };

ost_status ost_picture_init(ost_picture *picture, int width, int height, ost_error *err)
{
    memset(picture, 0, sizeof *picture);
    if (width < 1 || height < 1 || width > PICTURE_SIDE_MAX || height > PICTURE_SIDE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a picture of %d x %d pixels: expected 1 to %d a side", width, height,
                        PICTURE_SIDE_MAX);
    size_t bytes = (size_t)width * (size_t)height * 3;
    picture->rgb = calloc(bytes, 1);
    if (!picture->rgb)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a picture of %zu bytes", bytes);
    picture->width = width;
    picture->height = height;
    return OST_OK;
}

void ost_picture_free(ost_picture *picture)
{
    if (!picture)
        return;
    free(picture->rgb);
    memset(picture, 0, sizeof *picture);
}
