/* SPDX-License-Identifier: Apache-2.0 */
/* Finds properties of the device that --device names. */
#include "app/sim/sim.h"

#include "app/common/options.h"

bool sim_device_is(const sim_args *args, const char *name)
{
    return spec_is(args->device, name);
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
