/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 09: lists the backends, the devices on which they run, and the haptic
 * devices.
 *
 *   09_devices
 *
 * If an entry cannot be used on this machine, the reason and the package to install
 * are listed with it.
 */
#include <osteon/osteon.h>

#include <stdio.h>

/* This function is called for each device of a backend. The strings are valid until the function returns. */
static void show_device(const ost_device_info *device, void *user)
{
    (void)user;
    printf("  %-30s %s%s%s\n", device->spec, device->name, device->available ? "" : ": not available: ",
           device->available ? "" : device->reason);
}

int main(void)
{
    ost_error err = {OST_OK, ""};
    ost_backend_info backend;
    ost_haptic_info haptic;
    ost_status status = OST_OK;

    /* The version of the headers that compiled this program may differ from the version of the library that runs. */
    printf("osteon %s, arithmetic %d\n", ost_version(), OST_ARITHMETIC_VERSION);

    for (int i = 0; !status && i < ost_backend_count(); i++) {
        status = ost_backend_describe(i, &backend, &err);
        if (status)
            break;
        printf("backend %-8s %s\n", backend.name, backend.available ? backend.description : backend.reason);
        if (backend.available)
            status = ost_backend_devices(i, show_device, NULL, &err);
    }
    for (int i = 0; !status && i < ost_haptic_count(); i++) {
        status = ost_haptic_describe(i, &haptic, &err);
        if (!status)
            printf("haptic  %-12s %s\n", haptic.name, haptic.available ? haptic.description : haptic.reason);
    }
    if (status)
        fprintf(stderr, "09_devices: %s\n", err.text);
    return ost_status_exit(status);
}
