/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares digests with values that another implementation of SHA-256 (Python's hashlib) computed from bytes in the
 * layout of docs/spec/arithmetic.md. The comment of each test contains the Python expression.
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
    assert_string_equal(ost_digest_hex(&digest, hex),
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

/* hashlib.sha256(bytes(65537)).hexdigest() */
static void empty_leaf_has_the_expected_digest(void **state)
{
    (void)state;
    ost_error err = {0};
    static const int16_t zeros[OST_LEAF * OST_LEAF * OST_LEAF];
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    assert_ok(ost_digest_leaf16(zeros, &digest, &err));
    assert_string_equal(ost_digest_hex(&digest, hex),
                        "3266304f31be278d06c3bd3eb9aa3e00c59bedec0a890de466568b0b90b0e01f");
}

/*
 * A grid of 40 x 33 x 65 voxels with voxel = (7x + 131y + 1009z) mod 4000 - 1000 and 12 leaves,
 * so that every axis is padded and the tree is uneven:
 *   H(b) = the SHA-256 of the bytes b; the numbers 1 and 2 are one byte each
 *   tree(l) = l[0] if len(l) == 1 else H(1 + tree(l[:k]) + tree(l[k:])), where k is the greatest power of two < len(l)
 *   root = H(2 + b"OSTEONG1" + struct.pack("<II3iI3q3qiIQ", 2, 1, 40,33,65, 0, 470000000,470000000,10**9,
 *            -57340000000,0,5, 0, 32, 12) + bytes(32) + tree)
 */
static void uneven_grid_has_the_expected_root(void **state)
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
    assert_string_equal(ost_digest_hex(&root, hex), "b96bea408b4bfb78381fba21b82d43b1e7e09bbe8babd5f5ab4a465513ab4858");

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

/*
 * The bytes of each field of the header are distinct, and nonzero wherever possible, so that a moved or missing field
 * is detected. The 128 bytes are built one by one from the table of AR-DIG-4, not from a C layout:
 *   leaf i: 32 bytes of i + 1, i = 0..5; tree as above
 *   h = bytearray(128); h[0:8] = b"OSTEONG1"; h[8:12] = (2).to_bytes(4, "little"); h[12:16] = (3).to_bytes(4, "little")
 *   for i: h[16+4*i:20+4*i] = dims[i].to_bytes(4, "little"); h[32+8*i:40+8*i] = spacing[i].to_bytes(8, "little")
 *          h[56+8*i:64+8*i] = origin[i].to_bytes(8, "little", signed=True)
 *   h[80:84] = threshold.to_bytes(4, "little"); h[84:88] = (32).to_bytes(4, "little")
 *   h[88:96] = (6).to_bytes(8, "little")
 *   root = hashlib.sha256(b"\x02" + h + tree).hexdigest()
 */
static void every_header_field_has_its_position(void **state)
{
    (void)state;
    static const struct {
        ost_pm3 spacing;
        int32_t threshold;
        const char *root;
    } bones[] = {
        {{470000000, 510000000, OST_PM_PER_MM},
         0x01020384,
         "d51aa1e763e94a4cafcc0f0129d0c865d0fc2a6caf6e3acd86583ed8f1e1c589"},
        {{470000000, 470000000, 470000000}, 120, "0e5f372f0ede6877e908ac833f47e0de1e1659bc99ad71c9c7dd129477387e59"},
    };
    ost_error err = {0};
    ost_digest leaves[6], root;
    char hex[OST_DIGEST_HEX];
    for (int i = 0; i < 6; i++)
        memset(leaves[i].bytes, i + 1, sizeof leaves[i].bytes);
    for (size_t b = 0; b < sizeof bones / sizeof bones[0]; b++) {
        ost_geometry g = {{70, 40, 20}, bones[b].spacing, {INT64_C(-57340000000), 7, -1}};
        assert_ok(ost_digest_root(OST_GRID_BONE, &g, bones[b].threshold, leaves, 6, &root, &err));
        assert_string_equal(ost_digest_hex(&root, hex), bones[b].root);
    }
}

static void wrong_leaf_count_is_refused(void **state)
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
        cmocka_unit_test(empty_leaf_has_the_expected_digest),
        cmocka_unit_test(uneven_grid_has_the_expected_root),
        cmocka_unit_test(every_header_field_has_its_position),
        cmocka_unit_test(wrong_leaf_count_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
