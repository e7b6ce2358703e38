/* SPDX-License-Identifier: Apache-2.0 */
#include "app/film/frame_size.h"

#include "app/common/options.h"

ost_status frame_size(const app_state *app, const char *text, int *width, int *height, ost_error *err)
{
    int *out[2] = {width, height};
    const char *p = text ? text : "1280x720";
    for (int i = 0; i < 2; i++) {
        int n = 0;
        const char *begin = p;
        while (*p >= '0' && *p <= '9' && n <= OST_FRAME_MAX)
            n = 10 * n + (*p++ - '0');
        if (p == begin || n < 1 || n > OST_FRAME_MAX || (*p && (i == 1 || *p != 'x')))
            return usage_error(app, err,
                               "--size %s: expected WIDTHxHEIGHT, or one number for a square, each from 1 to %d", text,
                               OST_FRAME_MAX);
        *out[i] = n;
        if (i == 0 && !*p) {
            *height = n;
            break;
        }
        p++;
    }
    return OST_OK;
}
