/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/vendor.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *load(const vendor_library *library, const char **name, char reason[256])
{
    const char *given = getenv(library->variable);
    if (given && given[0]) {
        *name = given;
        void *handle = dlopen(given, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        const char *why = handle ? NULL : dlerror();
        if (!handle)
            snprintf(reason, 256, "cannot load the library in %s: %.180s", library->variable, why ? why : given);
        return handle;
    }
    for (const char *const *n = library->names; *n; n++) {
        *name = *n;
        void *handle = dlopen(*n, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        if (handle)
            return handle;
    }
    snprintf(reason, 256, "%s not found: install %s, or set %s to the library's path", library->names[0],
             library->product, library->variable);
    return NULL;
}

bool ost_vendor_load(const vendor_library *library, void *table, char reason[256])
{
    const char *name = "";
    void *handle = load(library, &name, reason);
    if (!handle)
        return false;
    for (size_t i = 0; i < library->count; i++) {
        void *symbol = dlsym(handle, library->symbols[i].name);
        if (!symbol) {
            snprintf(reason, 256, "%.100s lacks %s: install %s, or set %s to the library's path", name,
                     library->symbols[i].name, library->product, library->variable);
            return false;
        }
        /* POSIX guarantees that the address of a function fits into an object pointer. */
        memcpy((char *)table + library->symbols[i].offset, &symbol, sizeof symbol);
    }
    return true;
}
