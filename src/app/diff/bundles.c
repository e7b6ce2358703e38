/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon diff` for two bundles. The verb compares the digests of the results of two sites, so that the
 * sites do not need to exchange voxels.
 */
#include <sys/stat.h>

#include "app/diff/compare.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "validation/bundle/difference.h"

bool diff_is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static const char *text_of(const json_t *o, const char *key)
{
    const char *text = json_string_value(json_object_get(o, key));
    return text ? text : "";
}

static void print_difference(const app_state *app, const json_t *d)
{
    const json_t *chunk = json_object_get(d, "chunk"), *leaf = json_object_get(d, "leaf");
    char location[80] = "";
    if (chunk)
        snprintf(location, sizeof location, ", first in chunk (%lld, %lld, %lld) of 32^3",
                 (long long)json_integer_value(json_array_get(chunk, 0)),
                 (long long)json_integer_value(json_array_get(chunk, 1)),
                 (long long)json_integer_value(json_array_get(chunk, 2)));
    else if (leaf)
        snprintf(location, sizeof location, ", first in leaf %lld of 32^3", (long long)json_integer_value(leaf));
    print_line(app, "  %s: %s %lld: %s%s", text_of(d, "case"), text_of(d, "stage"),
               (long long)json_integer_value(json_object_get(d, "item")), text_of(d, "what"), location);
}

ost_status diff_bundles(const app_state *app, const char *a, const char *b, int64_t limit, ost_error *err)
{
    json_t *o;
    ost_status status = bundle_difference(a, b, a, b, &o, err);
    if (status != OST_OK)
        return status;
    const json_t *differences = json_object_get(o, "differences"), *remaining = json_object_get(o, "not_compared"),
                 *notes = json_object_get(o, "notes");
    const long long compared = (long long)json_integer_value(json_object_get(o, "compared"));
    const bool equal = json_is_true(json_object_get(o, "equal"));
    json_object_update(app->result, o);
    if (compared == 0)
        print_line(app, "nothing could be compared: %s and %s have no case with the same input", a, b);
    else if (equal)
        print_line(app, "equal: %s%lld case%s, by the digests of what the reference made", compared == 1 ? "" : "all ",
                   compared, compared == 1 ? "" : "s");
    else
        print_line(app, "%s: %zu of %lld case%s that could be compared",
                   json_array_size(differences) ? "different" : "no difference found", json_array_size(differences),
                   compared, compared == 1 ? "" : "s");
    for (size_t i = 0; i < json_array_size(notes); i++)
        print_line(app, "  the protocols differ: %s", json_string_value(json_array_get(notes, i)));
    for (size_t i = 0; i < json_array_size(differences) && (int64_t)i < limit; i++)
        print_difference(app, json_array_get(differences, i));
    if (json_array_size(remaining))
        print_line(app, "  not compared: %zu case%s%s", json_array_size(remaining),
                   json_array_size(remaining) == 1 ? "" : "s",
                   (int64_t)json_array_size(remaining) > limit ? "; the first:" : ":");
    for (size_t i = 0; i < json_array_size(remaining) && (int64_t)i < limit; i++)
        print_line(app, "    %s", json_string_value(json_array_get(remaining, i)));
    json_decref(o);
    return equal ? OST_OK : OST_ERR_DIFFER;
}
