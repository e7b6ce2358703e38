/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/memory.h"

#include <float.h>
#include <unistd.h>

double ost_machine_memory(void)
{
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? (double)pages * (double)page : DBL_MAX;
}

ost_status ost_memory_check(const char *path, const char *what, ost_dims dims, ost_error *err)
{
    const double bytes = 2.0 * (double)ost_dims_count(dims), all = ost_machine_memory();
    if (bytes <= all)
        return OST_OK;
    return ost_fail(err, OST_ERR_MEMORY, "%s: the %s of %d x %d x %d voxels takes %.3g GB; this machine has %.3g GB",
                    path, what, (int)dims.x, (int)dims.y, (int)dims.z, bytes * 1e-9, all * 1e-9);
}
