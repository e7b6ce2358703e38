/* SPDX-License-Identifier: Apache-2.0 */
#include "app/devices/devices.h"

#include "app/common/print.h"
#include "app/common/result.h"

void devices_put(const app_state *app, json_t *array, const char *name, bool available, const char *reason)
{
    json_t *row = json_object();
    put_text(row, "name", name);
    put_bool(row, "available", available);
    put_text(row, "reason", reason);
    append(array, row);
    print_line(app, "  %-11s %-4s %s", name, available ? "yes" : "no", reason);
}
