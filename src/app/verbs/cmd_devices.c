/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon devices`: lists backends, renderers and devices. If one of these is not available, states the
 * reason.
 */
#include "config.h"

#include <stdio.h>
#include <string.h>

#if defined __aarch64__ && defined __linux__
#include <sys/auxv.h>
#endif

#include "app/common/backend_choice.h"
#include "app/common/options.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "core/isa.h"
#include "render/gl/gl.h"
#include "window/window.h"

static void one(const app_state *app, json_t *array, const char *name, bool available, const char *reason)
{
    json_t *row = json_object();
    put_text(row, "name", name);
    put_bool(row, "available", available);
    put_text(row, "reason", reason);
    append(array, row);
    print_line(app, "  %-11s %-4s %s", name, available ? "yes" : "no", reason);
}

/* User data for the callback of ost_backend_devices: the state of the verb and its list. */
typedef struct device_list {
    const app_state *app;
    json_t *array;
} device_list;

static void one_device(const ost_device_info *device, void *user)
{
    const device_list *list = user;
    json_t *row = json_object();
    put_text(row, "backend", device->spec);
    put_text(row, "platform", device->platform);
    put_text(row, "name", device->name);
    put_bool(row, "available", device->available);
    put_text(row, "reason", device->reason);
    put_text(row, "notes", device->notes);
    append(list->array, row);
    print_line(list->app, "  %-24s %-4s %s%s%s", device->spec, device->available ? "yes" : "no", device->name,
               *device->name ? ", " : "", device->platform);
    if (*device->reason)
        print_line(list->app, "  %-24s      %s", "", device->reason);
    if (*device->notes)
        print_line(list->app, "  %-24s      %s", "", device->notes);
}

/* Lists the devices that the backends offer for selection. Only the OpenCL backend offers devices. */
static ost_status list_devices(const app_state *app, ost_error *err)
{
    device_list list = {.app = app, .array = json_array()};
    ost_status status = OST_OK;
    print_line(app, "%s", "");
    print_line(app, "OpenCL devices");
    for (int i = 0; i < ost_backend_count() && status == OST_OK; i++)
        status = ost_backend_devices(i, one_device, &list, err);
    if (json_array_size(list.array) == 0)
        print_line(app, "  none; see the reason at backend cl");
    put(app->result, "devices", list.array);
    return status;
}

/* Lists the instruction sets that this build supports on this machine, and the selected one. */
static void list_choices(const app_state *app, json_t *row, const ost_backend_settings *settings)
{
    json_t *array = json_array();
    char text[128] = "";
    for (int i = 0; i < OST_ISA_COUNT; i++) {
        if (!ost_isa_available((ost_isa)i))
            continue;
        const size_t used = strlen(text);
        append(array, json_string(ost_isa_name((ost_isa)i)));
        snprintf(text + used, sizeof text - used, "%s%s", used ? ", " : "", ost_isa_name((ost_isa)i));
    }
    put_text(row, "isa", settings->isa);
    put(row, "isas", array);
    print_line(app, "  %-16s works with %s on %d thread%s; there are %s", "", settings->isa, settings->threads,
               settings->threads == 1 ? "" : "s", text);
}

/*
 * Lists the backends. Each backend is opened briefly with the given --backend and --threads, so that the list shows
 * the settings that a verb would use.
 */
static ost_status list_backends(const app_state *app, ost_error *err)
{
    json_t *array = json_array();
    bool known = false;
    print_line(app, "backends");
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info = {0};
        ost_backend *backend = NULL;
        if (ost_backend_describe(i, &info, NULL) != OST_OK)
            continue;
        const bool chosen = backend_is(app, info.name);
        known = known || chosen;
        if (info.available) {
            ost_error why = {0};
            /* The backend "plugin" can be opened only if --backend names the file of the plugin. */
            const bool named = strcmp(info.name, "plugin") != 0 || chosen;
            const ost_status status = chosen  ? backend_choose(app, &backend, &why)
                                      : named ? ost_backend_open(info.name, &backend, &why)
                                              : OST_OK;
            info.available = status == OST_OK;
            snprintf(info.reason, sizeof info.reason, "%.*s", (int)sizeof info.reason - 1, why.text);
        }
        one(app, array, info.name, info.available, info.available ? info.description : info.reason);
        if (backend) {
            const ost_backend_settings settings = ost_backend_settings_get(backend);
            json_t *row = json_array_get(array, json_array_size(array) - 1);
            put_integer(row, "threads", settings.threads);
            if (*settings.isa)
                list_choices(app, row, &settings);
        }
        ost_backend_close(backend);
    }
    put(app->result, "backends", array);
    ost_backend *none = NULL;
    return known ? OST_OK : backend_choose(app, &none, err);
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
    print_line(app, "%s", "");
    print_line(app, "instruction sets of this processor");
    print_line(app, "  %s", count ? text : "none that osteon uses");
}

/* Prints the device's buttons in the order of their bits, each with its default action. `osteon sim
   --buttons` changes the actions. */
static void list_buttons(const app_state *app, json_t *row, const ost_haptic_info *info)
{
    json_t *buttons = json_object();
    char text[256] = "";
    for (int i = 0; i < info->button_count; i++) {
        const size_t used = strlen(text);
        put_text(buttons, info->buttons[i].name, ost_action_name(info->buttons[i].action));
        snprintf(text + used, sizeof text - used, "%s%s=%s", used ? "," : "", info->buttons[i].name,
                 ost_action_name(info->buttons[i].action));
    }
    put(row, "buttons", buttons);
    if (*text)
        print_line(app, "  %-11s      --buttons %s", "", text);
}

static void list_haptics(const app_state *app)
{
    json_t *array = json_array();
    print_line(app, "%s", "");
    print_line(app, "haptic devices");
    for (int i = 0; i < ost_haptic_count(); i++) {
        ost_haptic_info info;
        if (ost_haptic_describe(i, &info, NULL) != OST_OK)
            continue;
        one(app, array, info.name, info.available, info.available ? info.description : info.reason);
        json_t *row = json_array_get(array, json_array_size(array) - 1);
        put_bool(row, "force", info.caps & OST_HAPTIC_FORCE);
        put_bool(row, "torque", info.caps & OST_HAPTIC_TORQUE);
        put_bool(row, "orientation", info.caps & OST_HAPTIC_ORIENTATION);
        list_buttons(app, row, &info);
        put_real(row, "max_force_n", info.max_force_n);
        put_real(row, "max_stiffness_n_m", info.max_stiffness_n_m);
    }
    put(app->result, "haptics", array);
}

/* Opens OpenGL briefly and prints its version and driver, or the reason why OpenGL cannot be used. */
static void list_gl(const app_state *app, json_t *array)
{
    ost_gl *gl = NULL;
    ost_error why = {0};
    char text[OST_ERROR_TEXT];
    const bool there = !ost_gl_missing() && ost_gl_open(NULL, &gl, &why) == OST_OK;
    if (there) {
        const ost_gl_info info = ost_gl_info_get(gl);
        snprintf(text, sizeof text, "--renderer gl: OpenGL %s, %s, %s%s", info.version, info.driver, info.way,
                 info.software ? "; software: --renderer points is faster" : "");
    } else {
        snprintf(text, sizeof text, "%s", ost_gl_missing() ? ost_gl_missing() : why.text);
    }
    one(app, array, "gl", there, text);
    ost_gl_close(gl);
}

static void list_libraries(const app_state *app)
{
    json_t *array = json_array();
    print_line(app, "%s", "");
    print_line(app, "optional parts");
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
    one(app, array, "png", true, "pictures: export to .png, diff --html; stacks of PNG slices");
#else
    one(app, array, "png", false, "no pictures, no stacks of PNG slices; install libpng-dev and build again");
#endif
#ifdef HAVE_TIFF
    one(app, array, "tiff", true, "stacks of TIFF slices");
#else
    one(app, array, "tiff", false, "stacks of TIFF slices cannot be read; install libtiff-dev and build again");
#endif
    list_gl(app, array);
    const char *missing = ost_window_missing();
    one(app, array, "window", missing == NULL, missing ? missing : "the simulator's window: osteon sim");
#ifdef HAVE_LIBWEBSOCKETS
    one(app, array, "websockets", true, "--device inverse3: Haply's service");
#else
    one(app, array, "websockets", false, "no --device inverse3; install libwebsockets-dev and build again");
#endif
#if defined HAVE_EMBREE4 || defined HAVE_EMBREE3
    one(app, array, "embree", true, "--backend cpu:voxelizer=embree, and Embree's rows in osteon bench");
#else
    one(app, array, "embree", false,
        "no --backend cpu:voxelizer=embree (same grids without); install libembree-dev and build again");
#endif
    put(app->result, "libraries", array);
}

ost_status cmd_devices(app_state *app, int argc, char **argv, ost_error *err)
{
    const option options[] = {{.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--json]",
        .about = "Lists the backends, instruction sets, haptic devices and optional components that\n"
                 "work on this machine. For those that do not work, the list states the reason and\n"
                 "what to install. OSTEON_ISA, OMP_NUM_THREADS, --backend and --threads have the same\n"
                 "effect as for any other verb.",
        .options = options,
        .example = "  osteon devices\n  osteon devices --backend cpu:isa=avx2 --threads 1",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    put_text(app->result, "version", ost_version());
    put_integer(app->result, "arithmetic", OST_ARITHMETIC_VERSION);
    status = list_backends(app, err);
    if (status == OST_OK)
        status = list_devices(app, err);
    if (status != OST_OK)
        return status;
    list_instruction_sets(app);
    list_haptics(app);
    list_libraries(app);
    return OST_OK;
}
