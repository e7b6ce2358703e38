/* SPDX-License-Identifier: Apache-2.0 */
/* Parses the list "key=value,key=value" that follows a device's name. */
#include <string.h>

#include "haptics/driver.h"

enum { KEY = 24, VALUE = 600 };

ost_status ost_haptic_options(const char *device, const char *options, haptic_option *take, void *user, ost_error *err)
{
    for (const char *p = options; *p;) {
        char key[KEY], value[VALUE];
        const size_t k = strcspn(p, "=,"), v = p[k] == '=' ? strcspn(p + k + 1, ",") : 0;
        if (p[k] != '=' || k == 0 || k >= KEY || v == 0 || v >= VALUE)
            return ost_fail(err, OST_ERR_USAGE, "device %s: '%.60s' is not key=value", device, p);
        memcpy(key, p, k);
        key[k] = '\0';
        memcpy(value, p + k + 1, v);
        value[v] = '\0';
        ost_status status = take(user, key, value, err);
        if (status != OST_OK)
            return status;
        p += k + 1 + v;
        if (*p == ',' && !*++p)
            return ost_fail(err, OST_ERR_USAGE, "device %s: no option after the last ','", device);
    }
    return OST_OK;
}

ost_status ost_haptic_number(const char *device, const char *key, const char *value, double lo, double hi, double *out,
                             ost_error *err)
{
    ost_decimal d;
    int64_t millionths = 0;
    const char *end = value + strlen(value);
    const bool read = ost_decimal_read(value, end, &d) == end && ost_decimal_scale(&d, 1000000, &millionths, NULL);
    *out = (double)millionths / 1e6;
    if (!read || !(*out >= lo && *out <= hi))
        return ost_fail(err, OST_ERR_USAGE, "device %s: %s=%.40s; expected a number from %g to %g", device, key,
                        value, lo, hi);
    return OST_OK;
}

ost_status ost_haptic_integer(const char *device, const char *key, const char *value, int64_t lo, int64_t hi,
                              int64_t *out, ost_error *err)
{
    ost_decimal d;
    bool exact = false;
    const char *end = value + strlen(value);
    if (ost_decimal_read(value, end, &d) != end || !ost_decimal_scale(&d, 1, out, &exact) || !exact || *out < lo ||
        *out > hi)
        return ost_fail(err, OST_ERR_USAGE, "device %s: %s=%.40s; expected a whole number from %lld to %lld", device,
                        key, value, (long long)lo, (long long)hi);
    return OST_OK;
}
