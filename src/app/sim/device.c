/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the device that --device names. */
#include "app/sim/sim.h"

#include <string.h>

bool sim_device_is(const sim_args *args, const char *name)
{
    const size_t length = strcspn(args->device, ":");
    return strlen(name) == length && memcmp(args->device, name, length) == 0;
}

bool sim_follows_path(const sim_args *args)
{
    return sim_device_is(args, "sim") || sim_device_is(args, "script") || sim_device_is(args, "replay");
}

bool sim_device_info(const sim_args *args, ost_haptic_info *out)
{
    for (int i = 0; i < ost_haptic_count(); i++)
        if (ost_haptic_describe(i, out, NULL) == OST_OK && sim_device_is(args, out->name))
            return true;
    return false;
}
