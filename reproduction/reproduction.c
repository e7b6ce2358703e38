/* SPDX-License-Identifier: Apache-2.0 */
/* Records the settings of a run and describes the machine on which the run takes place. */
#include <stdio.h>
#include <string.h>

#include <osteon/status.h>

#include "reproduction/item.h"

#if defined __clang__
#define COMPILER "clang " __clang_version__
#elif defined __GNUC__
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "unknown"
#endif

const char *const reproduction_kind_names[3] = {"times", "counts", "pictures"};

void reproduction_show(const reproduction *r, const char *stage, double share)
{
    if (r->progress)
        r->progress(r->progress_user, stage, share);
}

typedef struct device_of {
    int platform, device;
    result_machine *machine;
} device_of;

/* Stores the device if its options string contains the platform and device numbers of the open backend. */
static void take_device(const ost_device_info *device, void *user)
{
    const device_of *of = user;
    char spec[64];
    snprintf(spec, sizeof spec, "cl:platform=%d,device=%d", of->platform, of->device);
    if (strcmp(device->spec, spec) == 0)
        snprintf(of->machine->device, sizeof of->machine->device, "%s", device->name);
}

static ost_status find_device(const ost_backend_settings *settings, result_machine *machine, ost_error *err)
{
    device_of of = {settings->platform, settings->device, machine};
    ost_backend_info info;
    ost_status status = OST_OK;
    for (int i = 0; i < ost_backend_count() && status == OST_OK; i++) {
        status = ost_backend_describe(i, &info, err);
        if (status == OST_OK && strcmp(info.name, "cl") == 0)
            status = ost_backend_devices(i, take_device, &of, err);
    }
    return status;
}

ost_status reproduction_begin(reproduction *r, ost_error *err)
{
    result_machine *m = &r->machine;
    char cpu[BENCH_TEXT];
    ost_backend *backend = NULL;
    *m = (result_machine){
        .processors = bench_cpus(), .memory_gb = (double)bench_memory() * 1e-9, .quick = r->bench.quick};
    r->models.progress = r->progress;
    r->models.progress_user = r->progress_user;
    const model *own;
    for (int id = 0; id < MODELS; id++)
        if (model_is_own(&r->models, (model_id)id)) {
            const ost_status read = model_get(&r->models, (model_id)id, &own, err);
            if (read != OST_OK)
                return read;
        }
    ost_status status = bench_backend(&r->bench, r->bench.threads, &backend, err);
    if (status != OST_OK)
        return status;
    const ost_backend_settings settings = ost_backend_settings_get(backend);
    m->threads = r->bench.threads;
    snprintf(m->cpu, sizeof m->cpu, "%.90s", bench_cpu_model(cpu));
    snprintf(m->backend, sizeof m->backend, "%.90s", r->bench.backend);
    snprintf(m->isa, sizeof m->isa, "%s", settings.isa);
    snprintf(m->compiler, sizeof m->compiler, "%s", COMPILER);
    snprintf(m->version, sizeof m->version, "%s", ost_version());
    if (settings.device >= 0) {
        snprintf(r->cl, sizeof r->cl, "cl:platform=%d,device=%d", settings.platform, settings.device);
        status = find_device(&settings, m, err);
    }
    if (m->device[0])
        snprintf(m->label, sizeof m->label, "%.60s, %.30s", m->device, ost_backend_name(backend));
    else
        snprintf(m->label, sizeof m->label, "%.48s, %s%s%s, %d thread%s", m->cpu, ost_backend_name(backend),
                 *m->isa ? " " : "", m->isa, m->threads, m->threads == 1 ? "" : "s");
    ost_backend_close(backend);
    return status;
}

void reproduction_end(reproduction *r)
{
    for (int k = 0; k < REPRODUCTION_MODELS; k++)
        for (int m = 0; m < BENCH_VOXEL_METHODS; m++)
            bench_voxel_frames_free(&r->frames[k][m]);
    methods_table_free(&r->by_chunks);
    methods_table_free(&r->by_resolution);
    model_store_free(&r->models);
}
