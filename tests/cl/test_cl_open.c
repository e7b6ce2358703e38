/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the opening of devices that work: the options of the backend, the devices that a spec selects, the kernel sets,
 * and the list of all devices.
 */
#include "cl/try_open.h"

static void options(void **state)
{
    (void)state;
    ost_cl_options o;
    ost_error err = {0};
    assert_ok(ost_cl_options_read("", &o, &err));
    assert_true(!o.platform[0] && !o.device[0] && o.workgroup == 0 && o.kernels == OST_CL_SET_AUTO && o.staging == 0);
    assert_ok(ost_cl_options_read("kernels=gpu,staging=1024", &o, &err));
    assert_true(o.kernels == OST_CL_SET_GPU && o.staging == 1024);
    assert_ok(ost_cl_options_read("kernels=cpu,order=7", &o, &err));
    assert_int_equal(o.order, 7);
    assert_true(o.kernels == OST_CL_SET_CPU);
    assert_ok(ost_cl_options_read("device=1,platform=Portable Computing,workgroup=64", &o, &err));
    assert_string_equal(o.platform, "Portable Computing");
    assert_string_equal(o.device, "1");
    assert_int_equal(o.workgroup, 64);
    static const char *const wrong[] =
        {"platform",           "platform=",    "device=",         "isa=avx2", "workgroup=0",  "workgroup=x",
         "workgroup=99999999", "threads=2",    "platform=0,,x=1", "=",        "workgroup=-1", "kernels",
         "kernels=",           "kernels=both", "staging=1023",    "staging=", "order=0",      "order=x",
         "staging=9999999999"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (ost_cl_options_read(wrong[i], &o, &err) != OST_ERR_USAGE)
            fail_msg("the options '%s' were accepted", wrong[i]);

    ost_cl_device d = {
        .platform_index = 1, .device_index = 2, .platform_name = "Portable Computing Language", .name = "pthread-Xeon"};
    d.id = (cl_device_id)&d;
    static const struct {
        const char *text;
        bool fits;
    } words[] = {
        {"", true},
        {"platform=1", true},
        {"platform=0", false},
        {"platform=portable", true},
        {"platform=LANGUAGE", true},
        {"platform=rusticl", false},
        {"device=2", true},
        {"device=1", false},
        {"device=xeon", true},
        {"platform=1,device=xeon", true},
        {"platform=0,device=xeon", false},
        {"device=pthread-Xeon!", false},
    };
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        assert_ok(ost_cl_options_read(words[i].text, &o, &err));
        if (ost_cl_options_match(&o, &d) != words[i].fits)
            fail_msg("the options '%s' %s the device", words[i].text, words[i].fits ? "do not match" : "match");
    }
}

static void no_such_device(void **state)
{
    (void)state;
    ost_error err;
    assert_int_equal(try_open(&ost_cl_loader, "platform=nobody's", &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "nobody's"));
    assert_int_equal(try_open(&ost_cl_loader, "device=4096", &err), OST_ERR_UNAVAILABLE);
    char huge[128];
    snprintf(huge, sizeof huge, "%s%sworkgroup=65536", own_options(), own_options()[0] ? "," : "");
    assert_int_equal(try_open(&ost_cl_loader, huge, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "at most"));
}

/* Opens two backends with different kernel sets on one device at the same time. Each backend must contain only the
   kernels of its own set. */
static void both_kernel_sets_at_once(void **state)
{
    (void)state;
    static const enum ost_cl_kernel own[2] = {OST_CL_KERNEL_ost_remove_blocks, OST_CL_KERNEL_ost_remove};
    ost_backend *backend[2] = {NULL, NULL};
    for (int i = 0; i < 2; i++) {
        ost_error err = {0};
        char text[256];
        snprintf(text, sizeof text, "%s%skernels=%s", own_options(), own_options()[0] ? "," : "", i ? "gpu" : "cpu");
        const ost_status status = ost_cl_open_with(&ost_cl_loader, text, &backend[i], &err);
        if (i == 0 && status == OST_ERR_UNAVAILABLE && strstr(err.text, "too early for kernels=cpu"))
            continue;
        assert_ok(status);
        backend[i]->ops = &ost_backend_cl;
        const cl_backend *b = (const cl_backend *)backend[i];
        assert_int_equal(b->cpu_set, i == 0);
        assert_non_null(b->kernel[own[i]]);
        assert_null(b->kernel[own[1 - i]]);
        assert_int_equal(b->launched[own[i]], 0);
        assert_true(b->launched[OST_CL_KERNEL_ost_fingerprint] > 0);
    }
    for (int i = 0; i < 2; i++)
        ost_backend_close(backend[i]);
}

typedef struct seen {
    int devices, available;
} seen;

static void check_device(const ost_device_info *device, void *user)
{
    seen *s = user;
    s->devices++;
    s->available += device->available;
    assert_int_equal(strncmp(device->spec, "cl:platform=", 12), 0);
    assert_true(device->platform[0] != 0);
    assert_true(device->available ? device->notes[0] != 0 && !device->reason[0] : device->reason[0] != 0);
}

static void devices_are_listed(void **state)
{
    (void)state;
    ost_error err = {0};
    seen s = {0, 0};
    for (int i = 0; i < ost_backend_count(); i++)
        assert_ok(ost_backend_devices(i, check_device, &s, &err));
    assert_true(s.available > 0);
    assert_int_equal(ost_backend_devices(-1, check_device, &s, &err), OST_ERR_USAGE);
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options),
        cmocka_unit_test(no_such_device),
        cmocka_unit_test(both_kernel_sets_at_once),
        cmocka_unit_test(devices_are_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
