/* SPDX-License-Identifier: Apache-2.0 */
#include "app/devices/devices.h"

#include <stdio.h>
#include <string.h>

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/result.h"
#include "core/isa.h"

/* User data for the callback of ost_backend_devices: the state of the verb and its list. */
typedef struct device_list {
    const app_state *app;
    json_t *array;
} device_list;

static void one_device(const ost_device_info *device, void *user)
{
    const device_list *list = user;
    json_t *row = json_object();
    put_text(row, "backend", device->spec);
    put_text(row, "platform", device->platform);
    put_text(row, "name", device->name);
    put_bool(row, "available", device->available);
    put_text(row, "reason", device->reason);
    put_text(row, "notes", device->notes);
    append(list->array, row);
    print_line(list->app, "  %-24s %-4s %s%s%s", device->spec, device->available ? "yes" : "no", device->name,
               *device->name ? ", " : "", device->platform);
    if (*device->reason)
        print_line(list->app, "  %-24s      %s", "", device->reason);
    if (*device->notes)
        print_line(list->app, "  %-24s      %s", "", device->notes);
}

ost_status devices_list_opencl(const app_state *app, ost_error *err)
{
    device_list list = {.app = app, .array = json_array()};
    ost_status status = OST_OK;
    print_line(app, "%s", "");
    print_line(app, "OpenCL devices");
    for (int i = 0; i < ost_backend_count() && status == OST_OK; i++)
        status = ost_backend_devices(i, one_device, &list, err);
    if (json_array_size(list.array) == 0)
        print_line(app, "  none; see the reason at backend cl");
    put(app->result, "devices", list.array);
    return status;
}

/* Lists the instruction sets that this build supports on this machine, and the selected one. */
static void list_choices(const app_state *app, json_t *row, const ost_backend_settings *settings)
{
    json_t *array = json_array();
    char text[128] = "";
    for (int i = 0; i < OST_ISA_COUNT; i++) {
        if (!ost_isa_available((ost_isa)i))
            continue;
        const size_t used = strlen(text);
        append(array, json_string(ost_isa_name((ost_isa)i)));
        snprintf(text + used, sizeof text - used, "%s%s", used ? ", " : "", ost_isa_name((ost_isa)i));
    }
    put_text(row, "isa", settings->isa);
    put(row, "isas", array);
    print_line(app, "  %-16s works with %s on %d thread%s; there are %s", "", settings->isa, settings->threads,
               settings->threads == 1 ? "" : "s", text);
}

ost_status devices_list_backends(const app_state *app, ost_error *err)
{
    json_t *array = json_array();
    bool known = false;
    print_line(app, "backends");
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info = {0};
        ost_backend *backend = NULL;
        if (ost_backend_describe(i, &info, NULL) != OST_OK)
            continue;
        const bool chosen = backend_is(app, info.name);
        known = known || chosen;
        if (info.available) {
            ost_error why = {0};
            /* The backend "plugin" can be opened only if --backend names the file of the plugin. */
            const bool named = strcmp(info.name, "plugin") != 0 || chosen;
            const ost_status status = chosen  ? backend_choose(app, &backend, &why)
                                      : named ? ost_backend_open(info.name, &backend, &why)
                                              : OST_OK;
            info.available = status == OST_OK;
            snprintf(info.reason, sizeof info.reason, "%.*s", (int)sizeof info.reason - 1, why.text);
        }
        devices_put(app, array, info.name, info.available, info.available ? info.description : info.reason);
        if (backend) {
            const ost_backend_settings settings = ost_backend_settings_get(backend);
            json_t *row = json_array_get(array, json_array_size(array) - 1);
            put_integer(row, "threads", settings.threads);
            if (*settings.isa)
                list_choices(app, row, &settings);
        }
        ost_backend_close(backend);
    }
    put(app->result, "backends", array);
    ost_backend *none = NULL;
    return known ? OST_OK : backend_choose(app, &none, err);
}
