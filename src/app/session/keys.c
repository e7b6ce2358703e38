/* SPDX-License-Identifier: Apache-2.0 */
#include "app/session/keys.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/input/glenoid_plan.h"
#include "app/common/result.h"

/* Writes keys to a header and stores the first failure, so that one check after a list of keys is sufficient. */
typedef struct writer {
    ost_session_header *header;
    ost_status status;
    ost_error *err;
} writer;

static void set(writer *w, const char *key, const char *value)
{
    if (w->status == OST_OK)
        w->status = ost_session_header_set(w->header, key, value, w->err);
}

static void set_integer(writer *w, const char *key, int64_t value)
{
    char text[24];
    snprintf(text, sizeof text, "%" PRId64, value);
    set(w, key, text);
}

static void set_mm(writer *w, const char *key, ost_pm value)
{
    char text[OST_PM_TEXT];
    set(w, key, ost_pm_format(value, text));
}

static void set_mm3(writer *w, const char *key, ost_pm3 v)
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT], text[3 * OST_PM_TEXT];
    snprintf(text, sizeof text, "%s,%s,%s", ost_pm_format(v.x, x), ost_pm_format(v.y, y), ost_pm_format(v.z, z));
    set(w, key, text);
}

static void set_digest(writer *w, const char *key, const ost_digest *digest)
{
    char hex[OST_DIGEST_HEX];
    set(w, key, ost_digest_hex(digest, hex));
}

/* Sets a key to the name at position `index` of a list such as "a|b|c". */
static void set_choice(writer *w, const char *key, const char *choices, int index)
{
    char text[40];
    for (; index > 0; index--)
        choices = strchr(choices, '|') + 1;
    snprintf(text, sizeof text, "%.*s", (int)strcspn(choices, "|"), choices);
    set(w, key, text);
}

static const char yes_no[] = "no|yes", units[] = "auto|mm|cm|m|inch|um", rules[] = "winding|parity",
                  duplicates[] = "error|first|last|max", sweeps[] = "off|on", forms[] = "auto|qform|sform",
                  resample_rules[] = "linear|nearest|thesis";

static void set_classes(writer *w, const ost_density_classes *classes)
{
    char text[OST_CLASS_MAX * (OST_CLASS_NAME + 8)] = "";
    size_t used = 0;
    for (int c = 0; c < classes->count; c++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s:%d", c ? "," : "", classes->name[c],
                                 classes->border[c]);
    set(w, "config.classes", text);
}

/* Sets the SHA-256 of all header lines that influence the result of a tick. */
static void set_config_digest(writer *w)
{
    ost_hasher *hasher = NULL;
    ost_digest digest;
    if (w->status == OST_OK)
        w->status = ost_hasher_open(&hasher, w->err);
    if (w->status != OST_OK)
        return;
    for (int i = 0; i < ost_session_header_count(w->header) && w->status == OST_OK; i++) {
        const char *key, *value;
        ost_session_header_entry(w->header, i, &key, &value);
        if (strncmp(key, "config.", 7) != 0)
            continue;
        const char *const parts[] = {key, ": ", value, "\n"};
        for (size_t k = 0; k < 4 && w->status == OST_OK; k++)
            w->status = ost_hasher_add(hasher, parts[k], strlen(parts[k]), w->err);
    }
    const ost_status closed = ost_hasher_close(hasher, &digest, w->status == OST_OK ? w->err : NULL);
    w->status = w->status == OST_OK ? closed : w->status;
    set_digest(w, "config_sha256", &digest);
}

static void set_build(writer *w)
{
    ost_digest digest;
    char text[200];
    set(w, "format", "osteon session 2");
    set(w, "osteon", ost_version());
    set_integer(w, "arithmetic", OST_ARITHMETIC_VERSION);
#if defined __clang__
    snprintf(text, sizeof text, "clang %s", __clang_version__);
#else
    snprintf(text, sizeof text, "gcc %s", __VERSION__);
#endif
    set(w, "build", text);
    /* if the process cannot read its own program file, the session does not contain this key */
    if (file_digest("/proc/self/exe", &digest, NULL) == OST_OK)
        set_digest(w, "build_sha256", &digest);
}

static void set_objects(writer *w, const session_setup *setup, const ost_bone *bone, ost_tool *const *tools)
{
    ost_digest digest;
    ost_bone_info info;
    char key[OST_SESSION_KEY], text[60];
    if (w->status == OST_OK)
        w->status = ost_bone_info_get(bone, &info, w->err);
    if (w->status == OST_OK)
        w->status = ost_bone_digest(bone, NULL, &digest, w->err);
    if (w->status != OST_OK)
        return;
    set(w, "bone", setup->bone);
    set_digest(w, "bone_sha256", &digest);
    const ost_dims d = info.geometry.dims;
    snprintf(text, sizeof text, "%d,%d,%d", d.x, d.y, d.z);
    set(w, "bone_dims", text);
    set_mm3(w, "bone_spacing_mm", info.geometry.spacing);
    set_mm3(w, "bone_origin_mm", info.geometry.origin);
    for (int i = 0; i < setup->tools.count && w->status == OST_OK; i++) {
        snprintf(key, sizeof key, "tool.%d", i);
        set(w, key, setup->tools.value[i]);
        w->status = w->status == OST_OK ? ost_tool_digest(tools[i], &digest, w->err) : w->status;
        snprintf(key, sizeof key, "tool_sha256.%d", i);
        set_digest(w, key, &digest);
    }
    set_integer(w, "config.threshold", info.threshold);
    set_integer(w, "config.chunk", info.chunk_size);
}

ost_status session_keys_make(const session_setup *setup, ost_backend *backend, const ost_bone *bone,
                             ost_tool *const *tools, const char *device, ost_session_header **out, ost_error *err)
{
    writer w = {.err = err};
    w.status = ost_session_header_create(out, err);
    if (w.status != OST_OK)
        return w.status;
    w.header = *out;
    set_build(&w);
    const ost_backend_settings settings = ost_backend_settings_get(backend);
    set(&w, "backend", ost_backend_name(backend));
    set(&w, "isa", settings.isa);
    set_integer(&w, "threads", settings.threads);
    set_objects(&w, setup, bone, tools);
    set_choice(&w, "config.sweep", sweeps, !setup->sweep_off);
    set_integer(&w, "config.removal_period_ns", setup->removal_period_ns);
    set_classes(&w, &setup->classes);
    set_config_digest(&w);
    set_mm(&w, "load.voxel", setup->how.voxel);
    set_choice(&w, "load.unit", units, setup->how.unit);
    set_choice(&w, "load.rule", rules, setup->how.rule);
    if (setup->ct.spacing.x)
        set_mm3(&w, "load.spacing", setup->ct.spacing);
    if (setup->ct.cubic)
        set_mm(&w, "load.cubic", setup->ct.cubic);
    if (setup->ct.crop)
        set(&w, "load.crop", setup->ct.crop);
    if (setup->ct.resample >= 0)
        set(&w, "load.resample", ost_resample_name((ost_resample)setup->ct.resample));
    set_choice(&w, "load.duplicates", duplicates, setup->ct.duplicates);
    set_choice(&w, "load.clamp", yes_no, setup->ct.clamp);
    set_choice(&w, "load.resample_oblique", yes_no, setup->ct.resample_oblique);
    if (setup->ct.orientation)
        set(&w, "load.orientation", setup->ct.orientation);
    if (setup->ct.form)
        set_choice(&w, "load.form", forms, setup->ct.form);
    set(&w, "device", device);
    if (w.status == OST_OK && setup->plan)
        w.status = glenoid_plan_set(w.header, setup->plan, err);
    if (w.status != OST_OK) {
        ost_session_header_free(*out);
        *out = NULL;
    }
    return w.status;
}

/* ---------------------------------------------------------------- reading */

typedef struct reader {
    const char *session;
    const ost_session_header *header;
    ost_status status;
    ost_error *err;
} reader;

/* Returns the value of a key, or NULL if the key is missing. If `needed` is true, a missing key is an error. */
static const char *get(reader *r, const char *key, bool needed)
{
    const char *value = r->status == OST_OK ? ost_session_header_get(r->header, key) : NULL;
    if (r->status == OST_OK && !value && needed)
        r->status = ost_fail(r->err, OST_ERR_INPUT, "%s: its header has no '%s'", r->session, key);
    return value;
}

static void wrong(reader *r, const char *key, const char *value)
{
    if (r->status == OST_OK)
        r->status = ost_fail(r->err, OST_ERR_INPUT, "%s: its header has '%s: %.80s', which is not valid", r->session,
                             key, value);
}

static int64_t get_integer(reader *r, const char *key, int64_t lo, int64_t hi)
{
    ost_decimal d;
    int64_t number = lo;
    bool exact = false;
    const char *value = get(r, key, true), *end = value ? value + strlen(value) : NULL;
    if (value && (ost_decimal_read(value, end, &d) != end || !ost_decimal_scale(&d, 1, &number, &exact) || !exact ||
                  number < lo || number > hi)) {
        wrong(r, key, value);
        return lo;
    }
    return number;
}

static ost_pm get_mm(reader *r, const char *key, bool needed)
{
    ost_pm out = 0;
    const char *value = get(r, key, needed);
    if (value && (ost_pm_parse(value, &out, NULL) != OST_OK || out <= 0))
        wrong(r, key, value);
    return out;
}

static ost_pm3 get_mm3(reader *r, const char *key)
{
    ost_pm v[3] = {0};
    const char *value = get(r, key, false), *p = value;
    for (int a = 0; value && a < 3; a++) {
        char part[OST_PM_TEXT];
        const size_t length = strcspn(p, ",");
        if (length >= sizeof part || p[length] != (a < 2 ? ',' : '\0')) {
            wrong(r, key, value);
            return (ost_pm3){0};
        }
        memcpy(part, p, length);
        part[length] = '\0';
        if (ost_pm_parse(part, &v[a], NULL) != OST_OK || v[a] <= 0)
            wrong(r, key, value);
        p += length + (a < 2);
    }
    return (ost_pm3){v[0], v[1], v[2]};
}

static int get_choice(reader *r, const char *key, const char *choices)
{
    const char *value = get(r, key, true);
    if (!value)
        return 0;
    const size_t length = strlen(value);
    for (int i = 0;; i++) {
        const size_t n = strcspn(choices, "|");
        if (n == length && memcmp(choices, value, n) == 0)
            return i;
        if (!choices[n]) {
            wrong(r, key, value);
            return 0;
        }
        choices += n + 1;
    }
}

ost_status session_keys_read(const char *session, const ost_session_header *header, session_setup *out, ost_error *err)
{
    reader r = {.session = session, .header = header, .err = err};
    char key[OST_SESSION_KEY];
    *out = (session_setup){.ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT};
    if (get_integer(&r, "arithmetic", 0, INT32_MAX) != OST_ARITHMETIC_VERSION && r.status == OST_OK)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: was recorded with version %s of the arithmetic; this osteon has version %d", session,
                        ost_session_header_get(header, "arithmetic"), OST_ARITHMETIC_VERSION);
    out->bone = get(&r, "bone", true);
    for (int i = 0; i < OPTION_LIST_MAX; i++) {
        snprintf(key, sizeof key, "tool.%d", i);
        const char *tool = get(&r, key, i == 0);
        if (!tool)
            break;
        out->tools.value[out->tools.count++] = tool;
    }
    out->ct.threshold = get_integer(&r, "config.threshold", 1, 32767);
    const int64_t chunk = get_integer(&r, "config.chunk", 16, 64);
    if (chunk != 16 && chunk != 32 && chunk != 64)
        wrong(&r, "config.chunk", ost_session_header_get(header, "config.chunk"));
    out->ct.chunk = chunk == 64 ? 2 : chunk == 32 ? 1 : 0;
    out->sweep_off = get_choice(&r, "config.sweep", sweeps) == 0;
    out->removal_period_ns = get_integer(&r, "config.removal_period_ns", 0, INT64_MAX);
    const char *classes = get(&r, "config.classes", true);
    if (classes && ost_density_classes_parse(classes, &out->classes, NULL) != OST_OK)
        wrong(&r, "config.classes", classes);
    out->how.voxel = get_mm(&r, "load.voxel", true);
    out->how.unit = get_choice(&r, "load.unit", units);
    out->how.rule = get_choice(&r, "load.rule", rules);
    out->ct.spacing = get_mm3(&r, "load.spacing");
    out->ct.cubic = get_mm(&r, "load.cubic", false);
    out->ct.crop = get(&r, "load.crop", false);
    out->ct.resample = ost_session_header_get(header, "load.resample") ? get_choice(&r, "load.resample", resample_rules)
                                                                       : -1;
    out->ct.duplicates = get_choice(&r, "load.duplicates", duplicates);
    out->ct.clamp = get_choice(&r, "load.clamp", yes_no) == 1;
    out->ct.resample_oblique = get_choice(&r, "load.resample_oblique", yes_no) == 1;
    out->ct.orientation = get(&r, "load.orientation", false);
    out->ct.form = get(&r, "load.form", false) ? get_choice(&r, "load.form", forms) : 0;
    return r.status;
}

/* Compares a digest with the digest in the header. `what` is "bone" or, for example, "tool 1". */
static ost_status check_digest(const char *session, const ost_session_header *header, const char *key, const char *what,
                               const char *name, const ost_digest *digest, ost_error *err)
{
    char hex[OST_DIGEST_HEX];
    const char *recorded = ost_session_header_get(header, key);
    if (!recorded)
        return ost_fail(err, OST_ERR_INPUT, "%s: its header has no '%s'", session, key);
    if (strcmp(recorded, ost_digest_hex(digest, hex)) != 0)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %s is not the %s of this session: its grid has the digest %.12s..., the session "
                        "recorded %.12s...",
                        session, name, what, hex, recorded);
    return OST_OK;
}

ost_status session_keys_check(const char *session, const ost_session_header *header, const session_setup *setup,
                              const ost_bone *bone, ost_tool *const *tools, ost_error *err)
{
    ost_digest digest;
    char key[OST_SESSION_KEY], what[20];
    ost_status status = ost_bone_digest(bone, NULL, &digest, err);
    if (status == OST_OK)
        status = check_digest(session, header, "bone_sha256", "bone", setup->bone, &digest, err);
    for (int i = 0; i < setup->tools.count && status == OST_OK; i++) {
        snprintf(key, sizeof key, "tool_sha256.%d", i);
        snprintf(what, sizeof what, "tool %d", i);
        status = ost_tool_digest(tools[i], &digest, err);
        if (status == OST_OK)
            status = check_digest(session, header, key, what, setup->tools.value[i], &digest, err);
    }
    return status;
}
