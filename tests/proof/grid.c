/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include <osteon/grid.h>
#include <osteon/tool.h>

/* Proves that the checks of a grid do not overflow for any input. If WIDE is defined, the checks accept longer
   spacings, and the proof must fail. */
#ifdef WIDE
#undef OST_SPACING_MAX
#define OST_SPACING_MAX INT64_MAX
#endif
#include "core/grid.c"
#include "core/tool.c"

void grid_check(void)
{
    ost_geometry geometry;
    ost_error err;
    (void)ost_geometry_check(&geometry, "", &err);
}

void grid_tool_check(void)
{
    ost_tool_geometry geometry;
    ost_error err;
    (void)ost_tool_geometry_check(&geometry, &err);
}
