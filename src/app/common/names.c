/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/names.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Computes the Levenshtein distance between two names. Returns LENGTH_MAX if a name is longer than LENGTH_MAX. */
static int distance(const char *a, const char *b)
{
    enum { LENGTH_MAX = 32 };
    size_t m = strlen(a), n = strlen(b);
    if (m > LENGTH_MAX || n > LENGTH_MAX)
        return LENGTH_MAX;
    int row[LENGTH_MAX + 1];
    for (size_t j = 0; j <= n; j++)
        row[j] = (int)j;
    for (size_t i = 1; i <= m; i++) {
        int diagonal = row[0];
        row[0] = (int)i;
        for (size_t j = 1; j <= n; j++) {
            int replace = diagonal + (a[i - 1] != b[j - 1]);
            int shift = 1 + (row[j] < row[j - 1] ? row[j] : row[j - 1]);
            diagonal = row[j];
            row[j] = replace < shift ? replace : shift;
        }
    }
    return row[n];
}

const char *nearest_name(const char *text, const char *const *names, int count)
{
    const char *best = NULL;
    int least = (int)strlen(text) / 3 + 1;
    for (int i = 0; i < count; i++) {
        int d = distance(text, names[i]);
        bool begins = strlen(text) >= 3 && strncmp(names[i], text, strlen(text)) == 0;
        if (begins)
            d = 0;
        if (d <= least && (!best || d < least)) {
            best = names[i];
            least = d;
        }
    }
    return best;
}

const char *spoken_list(char text[OPTION_SPOKEN], const char *names, const char *before)
{
    size_t used = 0;
    text[0] = '\0';
    for (;;) {
        size_t length = strcspn(names, "|");
        const char *next_name = names[length] ? names + length + 1 : NULL;
        const char *after = !next_name ? "" : strchr(next_name, '|') ? ", " : " or ";
        int n = snprintf(text + used, OPTION_SPOKEN - used, "%s%.*s%s", before, (int)length, names, after);
        used += n > 0 ? (size_t)n : 0;
        if (!next_name || used >= OPTION_SPOKEN)
            return text;
        names = next_name;
    }
}
