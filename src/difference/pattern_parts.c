/* SPDX-License-Identifier: Apache-2.0 */
#include "difference/pattern_parts.h"

#include <stdarg.h>
#include <stdio.h>

bool ost_pattern_describe(char *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(text, PATTERN_TEXT, format, args);
    va_end(args);
    return true;
}

int16_t ost_pattern_stored(const pattern_view *v, int16_t density)
{
    return v->input == PATTERN_THRESHOLDED && density < v->solid_a ? 0 : density;
}
