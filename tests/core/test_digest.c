/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Digests against values computed by another SHA-256 (Python's hashlib) over
 * the layout of docs/arithmetic.md; the snippet is beside each.
 * Covers: AR-DIG-1, AR-DIG-2, AR-DIG-3, AR-DIG-4
 */
#include "harness.h"

#include <osteon/digest.h>

static void bytes_are_plain_sha256(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    assert_ok(ost_digest_bytes("abc", 3, &digest, &err)); /* FIPS 180-4, example */
    assert_string_equal(ost_digest_hex(&digest, hex), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

/* hashlib.sha256(bytes(65537)).hexdigest() */
static void the_empty_leaf_is_constant(void **state)
{
    (void)state;
    ost_error err = {0};
    static const int16_t zeros[OST_LEAF * OST_LEAF * OST_LEAF];
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    assert_ok(ost_digest_leaf16(zeros, &digest, &err));
    assert_string_equal(ost_digest_hex(&digest, hex), "3266304f31be278d06c3bd3eb9aa3e00c59bedec0a890de466568b0b90b0e01f");
}

/*
 * 12 leaves of a 40 x 33 x 65 grid with voxel = (7x + 131y + 1009z) mod 4000 - 1000, so
 * every axis is padded and the tree is uneven:
 *   tree(l) = l[0] if one else H(1 + tree(l[:k]) + tree(l[k:])), k the greatest power of two < len(l)
 *   root = H(2 + b"OSTEONG1" + struct.pack("<II3iI3q3qiIQ", 1, 1, 40,33,65, 0, 470000000,470000000,10**9,
 *            -57340000000,0,5, 0, 32, 12) + bytes(32) + tree)
 */
static void an_uneven_grid_has_its_root(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_geometry g = {{40, 33, 65}, {470000000, 470000000, OST_PM_PER_MM}, {INT64_C(-57340000000), 0, 5}};
    ost_volume v;
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int z = 0; z < g.dims.z; z++)
        for (int y = 0; y < g.dims.y; y++)
            for (int x = 0; x < g.dims.x; x++)
                v.voxels[x + g.dims.x * (y + g.dims.y * z)] = (int16_t)((x * 7 + y * 131 + z * 1009) % 4000 - 1000);
    ost_digest root, other;
    char hex[OST_DIGEST_HEX];
    assert_ok(ost_digest_volume(OST_GRID_RECT, &v, &root, &err));
    assert_string_equal(ost_digest_hex(&root, hex), "677cb2d9d8bdef1dd3066dfea2e857e624f98347e8f455606ddae45666eda0b6");

    assert_ok(ost_digest_volume(OST_GRID_CUBIC, &v, &other, &err));
    assert_false(ost_digest_equal(&root, &other));
    v.voxels[40 * 33 * 65 - 1] ^= 1;
    assert_ok(ost_digest_volume(OST_GRID_RECT, &v, &other, &err));
    assert_false(ost_digest_equal(&root, &other));
    v.voxels[40 * 33 * 65 - 1] ^= 1;
    v.geometry.origin.z++;
    assert_ok(ost_digest_volume(OST_GRID_RECT, &v, &other, &err));
    assert_false(ost_digest_equal(&root, &other));
    ost_volume_free(&v);
}

static void a_wrong_leaf_count_is_refused(void **state)
{
    (void)state;
    ost_geometry g = {{40, 33, 65}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    ost_digest leaves[12] = {0};
    ost_digest root;
    assert_int_equal(ost_digest_root(OST_GRID_BONE, &g, 120, leaves, 11, &root, NULL), OST_ERR_USAGE);
    assert_int_equal(ost_digest_root(OST_GRID_BONE, &g, 120, leaves, 12, &root, NULL), OST_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_plain_sha256),
        cmocka_unit_test(the_empty_leaf_is_constant),
        cmocka_unit_test(an_uneven_grid_has_its_root),
        cmocka_unit_test(a_wrong_leaf_count_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
