/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Generates the glenoid component that is drawn as the planned implant: an oval with a domed back, a shallow dish in
 * front, and one peg. The back fits the surface that the built-in reamer leaves. The shape is not that of a product.
 * The frame is defined as for a tool: the lowest point of the back is the origin, the bone lies toward -z, and y is up.
 *
 *        z ^   ____________
 *          |  '-.________.-'   dish
 *          |   '-.______.-'    dome of 27 mm
 *          0       |  |        peg of 6 mm
 */
#ifndef OST_APP_PICTURE_IMPLANT_H
#define OST_APP_PICTURE_IMPLANT_H

#include <osteon/tool.h>

ost_status implant_make(ost_tool_volume *out, ost_error *err);

#endif
