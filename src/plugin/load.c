/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loads the table of a plugin: checks that the name refers to a regular file, that the
 * file can be loaded and contains the entry function, and that this function returns a
 * complete table of this version of the interface.  Each failure has its own message.
 */
#include "plugin/plugin.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define SLOTS(X)                                                                                                       \
    X(open)                                                                                                            \
    X(close) X(finish) X(grid_create) X(grid_free) X(grid_upload) X(grid_download) X(ct_to_rect) X(rect_to_cubic)      \
        X(cubic_to_chunks) X(bone_create) X(bone_free) X(bone_stats) X(bone_upload) X(bone_download) X(voxelize)       \
            X(tool_upload) X(tool_download) X(tool_free) X(remove) X(collide)

static ost_status check_table(const char *file, const ost_plugin *found, ost_plugin *table, char name[PLUGIN_NAME],
                              ost_error *err)
{
    /* The members abi and size exist in every version of the table. */
    if (found->abi != OST_PLUGIN_ABI)
        return ost_fail(err, OST_ERR_USAGE, "%s: built for version %u of the plugin interface; expected version %u",
                        file, (unsigned)found->abi, (unsigned)OST_PLUGIN_ABI);
    /* members from `snap` on were added without a new ABI number, so the table of an older plugin may lack them */
    const size_t least = offsetof(ost_plugin, snap);
    if (found->size < least)
        return ost_fail(err, OST_ERR_USAGE, "%s: its table has %u bytes; version %u of the plugin interface has %zu",
                        file, (unsigned)found->size, (unsigned)OST_PLUGIN_ABI, least);
    memset(table, 0, sizeof *table);
    memcpy(table, found, found->size < sizeof *table ? found->size : sizeof *table);
    if (!table->name || !table->name[0] || !table->description)
        return ost_fail(err, OST_ERR_USAGE, "%s: its table has no %s", file,
                        table->description ? "name" : "description");
#define CHECK_SLOT(slot) \
    if (!table->slot)    \
        return ost_fail(err, OST_ERR_USAGE, "%s: slot %s of its table is NULL; expected a function", file, #slot);
    SLOTS(CHECK_SLOT)
#undef CHECK_SLOT
    if (table->arithmetic != 0 && table->arithmetic != OST_ARITHMETIC_VERSION)
        return ost_fail(err, OST_ERR_USAGE,
                        "%s: follows version %d of docs/spec/arithmetic.md; this osteon compares with version %d", file,
                        (int)table->arithmetic, OST_ARITHMETIC_VERSION);
    snprintf(name, PLUGIN_NAME, "%.60s", table->name);
    return OST_OK;
}

ost_status ost_plugin_load(const char *file, ost_plugin *table, char name[PLUGIN_NAME], ost_error *err)
{
    char path[4096];
    struct stat info;
    /* A name without a slash refers to a file in the current folder. For such a name, dlopen would search the
       folders of system libraries instead. */
    const int n = snprintf(path, sizeof path, "%s%s", strchr(file, '/') ? "" : "./", file);
    if (n < 0 || (size_t)n >= sizeof path)
        return ost_fail(err, OST_ERR_USAGE, "plugin '%.60s...': the name is too long", file);
    if (stat(path, &info) != 0)
        return ost_fail(err, OST_ERR_IO, "plugin %s: cannot open: %s", file, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return ost_fail(err, OST_ERR_USAGE, "plugin %s: not a file", file);
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!handle) {
        const char *why = dlerror();
        return ost_fail(err, OST_ERR_INPUT, "plugin %s: cannot be loaded: %s", file, why ? why : "unknown reason");
    }
    ost_plugin_entry_function *entry = NULL;
    void *symbol = dlsym(handle, OST_PLUGIN_ENTRY);
    ost_status status = OST_OK;
    if (!symbol) {
        status = ost_fail(err, OST_ERR_INPUT, "plugin %s: has no symbol %s; see osteon/plugin.h", file,
                          OST_PLUGIN_ENTRY);
    } else {
        memcpy(&entry, &symbol, sizeof entry); /* in POSIX, an object pointer can hold the address of a function */
        const ost_plugin *found = entry(OST_PLUGIN_ABI);
        if (!found)
            status = ost_fail(err, OST_ERR_USAGE, "plugin %s: does not support version %u of the plugin interface",
                              file, (unsigned)OST_PLUGIN_ABI);
        else
            status = check_table(file, found, table, name, err);
    }
    dlclose(handle); /* the code remains loaded because of RTLD_NODELETE */
    return status;
}
