/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A glenoid component as a plan shows it: an oval with a domed back, which
 * fits what the built-in reamer leaves, a shallow dish in front, one peg.  A
 * shape of our own; no product's.  Its frame is a tool's: the back's lowest
 * point is the origin, the bone lies toward -z; y is up.
 *
 *        z ^   ____________
 *          |  '-.________.-'   dish
 *          |   '-.______.-'    dome of 27 mm
 *          0       |  |        peg of 6 mm
 */
#ifndef OST_APP_IMPLANT_H
#define OST_APP_IMPLANT_H

#include <osteon/tool.h>

ost_status implant_make(ost_tool_volume *out, ost_error *err);

#endif
