/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon devices: what works here, and the reason for what does not.
 */
#include "config.h"

#include <string.h>

#if defined __aarch64__ && defined __linux__
#include <sys/auxv.h>
#endif

#include "app/backend_choice.h"
#include "app/options.h"
#include "app/result.h"
#include "app/say.h"

static void one(const app_state *app, json_t *array, const char *name, bool available, const char *reason)
{
    json_t *row = json_object();
    put_text(row, "name", name);
    put_bool(row, "available", available);
    put_text(row, "reason", reason);
    append(array, row);
    say(app, "  %-9s %-4s %s", name, available ? "yes" : "no", reason);
}

static void list_backends(const app_state *app)
{
    json_t *array = json_array();
    say(app, "backends");
    if (backend_cpu_stands_in())
        one(app, array, "cpu", true, "the default; this build has no CPU backend yet, so the reference (ref) stands in: same grids, slower");
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info = {0};
        if (ost_backend_describe(i, &info, NULL) == OST_OK)
            one(app, array, info.name, info.available, info.available ? info.description : info.reason);
    }
    put(app->result, "backends", array);
}

static void list_instruction_sets(const app_state *app)
{
    json_t *array = json_array();
    char text[256] = "";
    const char *names[16];
    int count = 0;
#if defined __x86_64__
    __builtin_cpu_init();
#define OST_HAS(feature)                 \
    if (__builtin_cpu_supports(feature)) \
        names[count++] = feature;
    OST_HAS("sse2")
    OST_HAS("ssse3")
    OST_HAS("sse4.1")
    OST_HAS("avx2")
    OST_HAS("avx512f")
    OST_HAS("avx512bw")
    OST_HAS("avx512vl")
    OST_HAS("avx512vbmi")
#undef OST_HAS
#elif defined __aarch64__
    names[count++] = "neon";
#if defined __linux__ && defined HWCAP_SVE
    if (getauxval(AT_HWCAP) & HWCAP_SVE)
        names[count++] = "sve";
#endif
#endif
    for (int i = 0; i < count; i++) {
        append(array, json_string(names[i]));
        strcat(text, i ? ", " : "");
        strcat(text, names[i]);
    }
    put(app->result, "instruction_sets", array);
    say(app, "\ninstruction sets of this processor\n  %s", count ? text : "none that osteon looks for");
}

static void list_libraries(const app_state *app)
{
    json_t *array = json_array();
    say(app, "\noptional parts");
#ifdef HAVE_ASSIMP
    one(app, array, "assimp", true, "meshes: STL, OBJ, PLY, 3DS");
#else
    one(app, array, "assimp", false, "meshes cannot be read; install libassimp-dev and build again");
#endif
#ifdef HAVE_NIFTI
    one(app, array, "nifti", true, "NIfTI volumes: .nii, .nii.gz");
#else
    one(app, array, "nifti", false, "NIfTI volumes cannot be read; install libnifti-dev and build again");
#endif
#ifdef HAVE_PNG
    one(app, array, "png", true, "pictures: export to .png, diff --html");
#else
    one(app, array, "png", false, "no pictures; install libpng-dev and build again");
#endif
    put(app->result, "libraries", array);
}

ost_status cmd_devices(app_state *app, int argc, char **argv, ost_error *err)
{
    const option options[] = {{.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--json]",
        .about = "Says which backends, instruction sets and optional parts work here, and for what\n"
                 "does not the reason and what to install.",
        .options = options,
        .example = "  osteon devices",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    put_text(app->result, "version", ost_version());
    put_integer(app->result, "arithmetic", OST_ARITHMETIC_VERSION);
    list_backends(app);
    list_instruction_sets(app);
    list_libraries(app);
    return OST_OK;
}
