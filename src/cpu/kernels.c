/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/kernels.h"

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa)
{
    *kernels = (ost_cpu_kernels){.isa = isa};
}
