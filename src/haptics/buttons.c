/* SPDX-License-Identifier: Apache-2.0 */
/* Defines the names of button actions, and parses "button=action,button=action". */
#include <string.h>

#include "haptics/driver.h"

static const char *const names[OST_ACTION_COUNT] = {"none", "motor", "motor-switch", "next-tool", "clutch", "home"};

const char *ost_action_name(ost_action action)
{
    return (unsigned)action < OST_ACTION_COUNT ? names[action] : "unknown";
}

typedef struct choice {
    const ost_haptic_info *info;
    ost_action *of;
} choice;

/* Returns the index of the button with this name, or with this number (counted from 1). Returns -1
   if there is no such button. */
static int button_of(const ost_haptic_info *info, const char *key)
{
    for (int i = 0; i < info->button_count; i++)
        if (strcmp(info->buttons[i].name, key) == 0 || (key[0] == '1' + i && key[1] == '\0'))
            return i;
    return -1;
}

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    const choice *c = user;
    const int button = button_of(c->info, key);
    if (button < 0)
        return ost_fail(err, OST_ERR_USAGE, "device %s: unknown button '%s'; see osteon devices", c->info->name, key);
    for (int a = 0; a < OST_ACTION_COUNT; a++)
        if (strcmp(names[a], value) == 0) {
            c->of[button] = (ost_action)a;
            return OST_OK;
        }
    return ost_fail(err, OST_ERR_USAGE,
                    "device %s: %s=%.40s; expected none, motor, motor-switch, next-tool, clutch or home",
                    c->info->name, key, value);
}

ost_status ost_buttons_parse(const ost_haptic_info *info, const char *text, ost_action out[OST_BUTTONS_MAX],
                             ost_error *err)
{
    ost_action chosen[OST_BUTTONS_MAX] = {OST_ACTION_NONE};
    for (int i = 0; i < info->button_count; i++)
        chosen[i] = info->buttons[i].action;
    if (text && info->button_count == 0)
        return ost_fail(err, OST_ERR_USAGE, "device %s has no buttons", info->name);
    ost_status status = text ? ost_haptic_options(info->name, text, take, &(choice){info, chosen}, err) : OST_OK;
    if (status == OST_OK)
        memcpy(out, chosen, sizeof chosen);
    return status;
}
