/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/scratch.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

ost_status scratch_make(char path[SCRATCH_PATH], ost_error *err)
{
    const char *base = getenv("TMPDIR");
    const int n = snprintf(path, SCRATCH_PATH, "%s/osteon-validate-XXXXXX", base && *base ? base : "/tmp");
    if (n >= SCRATCH_PATH || !mkdtemp(path)) {
        ost_status status = ost_fail(err, OST_ERR_IO, "no folder for traces in '%.200s': %s", base && *base ? base : "/tmp",
                                     n >= SCRATCH_PATH ? "the name is too long" : strerror(errno));
        path[0] = '\0';
        return status;
    }
    return OST_OK;
}

void scratch_remove(const char *path)
{
    if (*path)
        rmdir(path);
}
