/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/mask_option.h"

#include <string.h>
#include <unistd.h>

/* Returns the colon after the file name, or NULL if the text consists only of a file name. */
static char *find_colon(char *text)
{
    if (access(text, F_OK) == 0)
        return NULL;
    for (char *colon = strchr(text, ':'); colon; colon = strchr(colon + 1, ':')) {
        *colon = 0;
        const bool is_file = access(text, F_OK) == 0;
        *colon = ':';
        if (is_file)
            return colon;
    }
    return strrchr(text, ':');
}

ost_status mask_option_parse(const app_state *app, const char *text, ost_import_options *out, ost_error *err)
{
    static char copy[4096];
    const size_t length = strlen(text);
    if (length >= sizeof copy)
        return usage_error(app, err, "--mask '%.80s...': the name is too long", text);
    memcpy(copy, text, length + 1);
    char *colon = find_colon(copy);
    if (colon)
        *colon = 0;
    out->mask = copy;
    if (!*copy || (colon && !colon[1]))
        return usage_error(app, err, "--mask '%.80s': expected FILE or FILE:LABEL,...", text);
    for (char *item = colon ? colon + 1 : NULL, *next; item; item = next) {
        next = strchr(item, ',');
        if (next)
            *next++ = 0;
        const bool is_number = *item && strspn(item, "0123456789") == strlen(item);
        int32_t value = 0;
        for (const char *p = item; is_number && *p && value <= INT16_MAX; p++)
            value = 10 * value + (*p - '0');
        if (!*item || value > INT16_MAX || out->mask_label_count == OST_MASK_LABELS_MAX ||
            out->mask_name_count == OST_MASK_LABELS_MAX)
            return usage_error(app, err, "--mask '%.80s': expected at most %d labels from 0 to %d or names, such as "
                               "FILE:71,72 or FILE:scapula", text, OST_MASK_LABELS_MAX, INT16_MAX);
        if (is_number)
            out->mask_labels[out->mask_label_count++] = (int16_t)value;
        else
            out->mask_names[out->mask_name_count++] = item;
    }
    return OST_OK;
}
