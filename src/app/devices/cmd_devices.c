/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon devices`: lists backends, renderers and devices. If one of these is not available, states the
 * reason.
 */
#include "app/common/options.h"
#include "app/common/result.h"
#include "app/devices/devices.h"

ost_status cmd_devices(app_state *app, int argc, char **argv, ost_error *err)
{
    const option options[] = {{.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--json]",
        .about = "Lists the backends, instruction sets, haptic devices and optional components that\n"
                 "work on this machine. For those that do not work, the list states the reason and\n"
                 "what to install. OSTEON_ISA, OMP_NUM_THREADS, --backend and --threads have the same\n"
                 "effect as for any other verb.",
        .options = options,
        .example = "  osteon devices\n  osteon devices --backend cpu:isa=avx2 --threads 1",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    put_text(app->result, "version", ost_version());
    put_integer(app->result, "arithmetic", OST_ARITHMETIC_VERSION);
    status = devices_list_backends(app, err);
    if (status == OST_OK)
        status = devices_list_opencl(app, err);
    if (status != OST_OK)
        return status;
    devices_list_instruction_sets(app);
    devices_list_haptics(app);
    devices_list_libraries(app);
    return OST_OK;
}
