/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/insides.h"

#include <stdio.h>

ost_status headset_check(const ost_headset *h, XrResult result, const char *doing, ost_error *err)
{
    char name[XR_MAX_RESULT_STRING_SIZE] = "";
    if (XR_SUCCEEDED(result))
        return OST_OK;
    if (h->instance == XR_NULL_HANDLE || XR_FAILED(xrResultToString(h->instance, result, name)))
        snprintf(name, sizeof name, "result %d", (int)result);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "the OpenXR runtime %s fails as it %s: %s",
                    *h->info.runtime ? h->info.runtime : "here", doing, name);
}
