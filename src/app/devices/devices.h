/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lists of `osteon devices`. Each function prints a list and stores it in the result of the verb.
 *
 *   backends.c    the backends, with their instruction sets, and the devices of OpenCL
 *   processor.c   the instruction sets of the processor
 *   haptics.c     the haptic devices
 *   libraries.c   the optional libraries, OpenGL and the window
 */
#ifndef OST_APP_DEVICES_DEVICES_H
#define OST_APP_DEVICES_DEVICES_H

#include "app/common/app.h"

/* Prints an entry of a list and appends it to the array. `reason` describes the entry or states why it is missing. */
void devices_put(const app_state *app, json_t *array, const char *name, bool available, const char *reason);

/*
 * Lists the backends. Each backend is opened briefly with the given --backend and --threads, so that the list shows
 * the settings that a verb would use.
 */
ost_status devices_list_backends(const app_state *app, ost_error *err);
/* Lists the devices that the backends offer for selection. Only the OpenCL backend offers devices. */
ost_status devices_list_opencl(const app_state *app, ost_error *err);

/* Lists the instruction sets that osteon can use and that the processor supports. */
void devices_list_instruction_sets(const app_state *app);
/* Lists the haptic devices with their buttons and their limits. */
void devices_list_haptics(const app_state *app);
/* Lists the optional parts that this build contains, and what to install for the others. */
void devices_list_libraries(const app_state *app);

#endif
