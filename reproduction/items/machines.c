/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Table 3.6: the machine of this run or, in a merged report, the machines of all runs, followed by the thesis'
 * computers.
 */
#include <stdio.h>

#include "reproduction/item.h"
#include "reproduction/stated.h"

enum { CPU, DEVICE, ISA, THREADS, MEMORY, COMPILER_COLUMN, VERSION };

ost_status item_machines(reproduction *r, result *out, ost_error *err)
{
    const result_machine *m = &r->machine;
    result_add_column(out, "cpu", "processor", "text");
    result_add_column(out, "device", "OpenCL device", "text");
    result_add_column(out, "isa", "instruction set", "text");
    result_add_column(out, "threads", "threads", "");
    result_add_column(out, "memory_GB", "free memory", "GB");
    result_add_column(out, "compiler", "compiler", "text");
    result_add_column(out, "version", "osteon", "text");
    result_add_row(out);
    result_set_text(out, CPU, "%s", m->cpu);
    result_set_text(out, DEVICE, "%s", m->device[0] ? m->device : "none used");
    result_set_text(out, ISA, "%s", m->isa[0] ? m->isa : "-");
    result_set(out, THREADS, m->threads);
    result_set(out, MEMORY, m->memory_gb);
    result_set_text(out, COMPILER_COLUMN, "%s", m->compiler);
    result_set_text(out, VERSION, "%s", m->version);
    for (int i = 0; i < STATED_COMPUTERS; i++) {
        const stated_computer *c = &stated_computers[i];
        result_add_remark(out, "Thesis: %s (%s GHz), %s (%s MHz%s%s%s%s%s), %s GB of memory, Windows 10.", c->cpu,
                          c->cpu_ghz, c->gpu, c->gpu_mhz, *c->cores ? ", " : "", c->cores, *c->cores ? " cores" : "",
                          *c->vram_gb ? ", GDDR5 in GB: " : "", c->vram_gb, c->ram_gb);
    }
    (void)err;
    return OST_OK;
}
