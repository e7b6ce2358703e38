/* SPDX-License-Identifier: Apache-2.0 */
#include "app/devices/devices.h"

#include <stdio.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"

/* Prints the device's buttons in bit order, each with its default action. `osteon sim --buttons` changes actions. */
static void list_buttons(const app_state *app, json_t *row, const ost_haptic_info *info)
{
    json_t *buttons = json_object();
    char text[256] = "";
    for (int i = 0; i < info->button_count; i++) {
        const size_t used = strlen(text);
        put_text(buttons, info->buttons[i].name, ost_action_name(info->buttons[i].action));
        snprintf(text + used, sizeof text - used, "%s%s=%s", used ? "," : "", info->buttons[i].name,
                 ost_action_name(info->buttons[i].action));
    }
    put(row, "buttons", buttons);
    if (*text)
        print_line(app, "  %-11s      --buttons %s", "", text);
}

void devices_list_haptics(const app_state *app)
{
    json_t *array = json_array();
    print_line(app, "%s", "");
    print_line(app, "haptic devices");
    for (int i = 0; i < ost_haptic_count(); i++) {
        ost_haptic_info info;
        if (ost_haptic_describe(i, &info, NULL) != OST_OK)
            continue;
        devices_put(app, array, info.name, info.available, info.available ? info.description : info.reason);
        json_t *row = json_array_get(array, json_array_size(array) - 1);
        put_bool(row, "force", info.caps & OST_HAPTIC_FORCE);
        put_bool(row, "torque", info.caps & OST_HAPTIC_TORQUE);
        put_bool(row, "orientation", info.caps & OST_HAPTIC_ORIENTATION);
        list_buttons(app, row, &info);
        put_real(row, "max_force_n", info.max_force_n);
        put_real(row, "max_stiffness_n_m", info.max_stiffness_n_m);
    }
    put(app->result, "haptics", array);
}
