/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the memory that the CPU backend needs for a bone with a complete scapula. The densities of the active chunks
 * take 13.2 MB, as in the thesis (Table 3.2: 202 chunks of 32^3). Occupancy adds 1/16 of this size. Occupancy, tables
 * and unused space together may add at most 1/10 of it.
 *
 * The memory is measured in two ways: as reported by the backend, chunk by chunk, and as the
 * growth of this process's anonymous memory, as reported by the system.
 * Covers: REQ-CPU-MEMORY
 */
#include "harness.h"

#include <osteon/backend.h>
#include <osteon/phantom.h>

enum { SCAPULA_CHUNKS = 202, CHUNK = 32 };

/* Returns the resident size in bytes of the process's anonymous memory, or -1 if the system does not report it. */
static int64_t resident(void)
{
    FILE *status = fopen("/proc/self/status", "r");
    char line[200];
    long kib = -1;
    while (status && fgets(line, sizeof line, status))
        if (sscanf(line, "RssAnon: %ld kB", &kib) == 1)
            break;
    if (status)
        (void)fclose(status);
    return kib < 0 ? -1 : kib * INT64_C(1024);
}

/* Returns false under sanitizers, valgrind and emulators, whose own data are part of the process's memory. */
static bool memory_can_be_measured(void)
{
#if defined __SANITIZE_ADDRESS__
    return false;
#elif defined __has_feature
#if __has_feature(address_sanitizer)
    return false;
#endif
#endif
    const char *preloaded = getenv("LD_PRELOAD");
    return !(preloaded && strstr(preloaded, "vgpreload")) && !getenv("OST_TEST_EMULATED");
}

static ost_bone *bone_of(ost_backend *backend, const ost_volume *ct)
{
    ost_error err = {0};
    ost_grid *rect, *cubic;
    ost_bone *bone;
    assert_ok(ost_grid_create(backend, &ct->geometry, &rect, &err));
    assert_ok(ost_grid_upload(rect, 0, ct->geometry.dims.z, ct->voxels, &err));
    assert_ok(ost_rect_to_cubic(rect, ct->geometry.spacing.x, OST_RESAMPLE_THESIS, &cubic, &err));
    ost_grid_free(rect);
    assert_ok(ost_cubic_to_chunks(cubic, CHUNK, 120, &bone, &err));
    ost_grid_free(cubic);
    return bone;
}

static void memory_of_an_imported_scapula(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume ct, small;
    ost_backend *backend;
    ost_bone_info info;
    assert_ok(ost_phantom_make(OST_PHANTOM_SCAPULA, NULL, &ct, &err));
    assert_ok(ost_phantom_make(OST_PHANTOM_GLENOID, NULL, &small, &err));
    /* Starts the threads and loads all code, so that the measurement includes neither. */
    assert_ok(ost_backend_open("cpu:threads=2", &backend, &err));
    ost_bone_free(bone_of(backend, &small));
    ost_backend_close(backend);
    ost_volume_free(&small);
    assert_ok(ost_backend_open("cpu:threads=2", &backend, &err));

    const int64_t densities = (int64_t)SCAPULA_CHUNKS * CHUNK * CHUNK * CHUNK * (int64_t)sizeof(int16_t);
    const int64_t most = densities + densities / 10;
    const int64_t before = resident();
    ost_bone *bone = bone_of(backend, &ct);
    const int64_t grown = resident() - before;
    assert_ok(ost_bone_info_get(bone, &info, &err));
    print_message("bytes: densities %lld, chunks %lld, reported by the backend %lld (%.1f %% more than densities), "
                  "growth of the process %lld\n",
                  (long long)densities, (long long)info.chunk_bytes, (long long)info.resident_bytes,
                  100.0 * (double)(info.resident_bytes - densities) / (double)densities, (long long)grown);
    assert_int_equal(info.active_chunks, SCAPULA_CHUNKS);
    assert_int_equal(info.chunk_bytes, densities + densities / 16);
    assert_true(info.resident_bytes > info.chunk_bytes);
    assert_true(info.resident_bytes <= most);
    if (before >= 0 && memory_can_be_measured()) {
        assert_true(grown <= most);
        assert_true(grown >= info.chunk_bytes - info.chunk_bytes / 50); /* The measurement must include the chunks. */
    }
    ost_bone_free(bone);
    ost_backend_close(backend);
    ost_volume_free(&ct);
}

/* A bone that is uploaded slice by slice, without a grid, must not need more memory than a bone made from a grid. */
static void memory_of_an_uploaded_bone(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume ct;
    ost_backend *backend;
    ost_bone *bone;
    ost_bone_info info;
    assert_ok(ost_phantom_make(OST_PHANTOM_GLENOID, NULL, &ct, &err));
    assert_ok(ost_backend_open("cpu:threads=2", &backend, &err));
    ct.geometry.spacing.z = ct.geometry.spacing.x; /* A bone needs equal spacings, so the phantom is flattened. */
    for (int n = 16; n <= 64; n *= 2) {
        assert_ok(ost_bone_create(backend, &ct.geometry, n, 120, &bone, &err));
        assert_ok(ost_bone_upload(bone, 0, ct.geometry.dims.z, ct.voxels, &err));
        assert_ok(ost_bone_info_get(bone, &info, &err));
        const int64_t densities = info.active_chunks * n * n * n * 2;
        assert_int_equal(info.chunk_bytes, densities + densities / 16);
        assert_true(info.resident_bytes <= densities + densities / 10);
        ost_bone_free(bone);
    }
    ost_backend_close(backend);
    ost_volume_free(&ct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_of_an_imported_scapula),
        cmocka_unit_test(memory_of_an_uploaded_bone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
