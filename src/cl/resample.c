/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/objects.h"

ost_status ost_cl_resample(cl_backend *b, ost_dims dims, bool linear, cl_mem cubic, cl_mem sources, cl_mem from,
                           cl_mem to, ost_error *err)
{
    const size_t x = ((size_t)dims.x + (size_t)b->run - 1) / (size_t)b->run, y = (size_t)dims.y, z = (size_t)dims.z;
    if (linear)
        return OST_CL_LAUNCH(b, ost_cubic_linear, x, y, z, err, OST_CL_ARG(cubic), OST_CL_ARG(sources),
                             OST_CL_ARG(from), OST_CL_ARG(to));
    return OST_CL_LAUNCH(b, ost_cubic_gather, x, y, z, err, OST_CL_ARG(cubic), OST_CL_ARG(sources), OST_CL_ARG(from),
                         OST_CL_ARG(to));
}
