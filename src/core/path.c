/* SPDX-License-Identifier: Apache-2.0 */
#include <osteon/path.h>

#include <stdlib.h>

ost_status ost_path_init(ost_path *path, size_t count, ost_error *err)
{
    *path = (ost_path){0};
    if (count > OST_PATH_TICKS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a path of %zu ticks; expected at most %d", count, OST_PATH_TICKS_MAX);
    path->ticks = malloc((count ? count : 1) * sizeof *path->ticks);
    if (!path->ticks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a path of %zu ticks", count);
    path->count = count;
    return OST_OK;
}

void ost_path_free(ost_path *path)
{
    if (!path)
        return;
    free(path->ticks);
    *path = (ost_path){0};
}
