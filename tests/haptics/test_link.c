/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the packets of the link, byte for byte. The expected bytes and HMACs were computed with Python's struct and
 * hmac from the table in docs/reference/devices.md. Further tests check keys, sequence numbers, and packets that must
 * be refused. The last two tests check the plane from which a bridge computes its force: the force never attracts the
 * device, and a closed loop with a delay is stable.
 * Covers: REQ-LINK
 */
#include "harness.h"

#include <math.h>

#include "haptics/bridge.h"
#include "haptics/driver.h"
#include "io/io_scratch.h"

static const char pose_hex[] =
    "4f53544c01020100887766554433221101ffeeddccbbaa99070000000000000015cd5b0700000000003665c4ffffffff00f9029500000000"
    "f9ffffffffffffff0000004000000000fbffffff0300000001000080ffffffff"
    "6cbfd0e7851e60ed629f33b768bedc1253bce7f29be74569379a515e86de2dae";
static const char state_hex[] =
    "4f53544c01030400887766554433221101ffeeddccbbaa9909000000000000000700000000000000003665c4ffffffff00f9029500000000"
    "f9ffffffffffffff0000004000000000fbffffff0300000060e31600feffffff00000000010000006079feff03000000e0930400f4010000"
    "6f4d3b4954a9721edb8a64d0f6ef2f56f1f65b6385e3019c55e09f71c60e4484";

static link_packet golden(uint8_t type)
{
    link_packet p = {.type = type, .bridge = UINT64_C(0x1122334455667788), .simulation = UINT64_C(0x99aabbccddeeff01),
                     .pose = {.t = {-1000000000, 2500000000, -7}, .qw = OST_Q30_ONE, .qy = -5, .qz = 3}};
    if (type == LINK_POSE) {
        p.flags = LINK_SEEN;
        p.sequence = 7;
        p.t_ns = 123456789;
        p.buttons = 0x80000001u;
        p.tool = -1;
    } else {
        p.flags = LINK_AGAIN;
        p.sequence = 9;
        p.answers = 7;
        memcpy(p.force_un, (int32_t[3]){1500000, -2, 0}, sizeof p.force_un);
        memcpy(p.torque_unm, (int32_t[3]){1, -100000, 3}, sizeof p.torque_unm);
        p.stiffness = 300000;
        p.damping = 500;
    }
    return p;
}

static link_key *key_from(int first)
{
    ost_error err = {0};
    uint8_t bytes[32];
    link_key *key;
    for (int i = 0; i < 32; i++)
        bytes[i] = (uint8_t)(first + i);
    assert_ok(ost_link_key_make(bytes, sizeof bytes, &key, &err));
    return key;
}

static void bytes_are_as_documented(void **state)
{
    (void)state;
    link_key *key = key_from(1);
    const char *const hex[] = {pose_hex, state_hex};
    const uint8_t types[] = {LINK_POSE, LINK_STATE};
    const size_t sizes[] = {LINK_POSE_BYTES, LINK_STATE_BYTES};
    for (int i = 0; i < 2; i++) {
        uint8_t bytes[LINK_STATE_BYTES];
        char text[2 * LINK_STATE_BYTES + 1];
        const link_packet p = golden(types[i]);
        assert_int_equal(ost_link_seal(key, &p, bytes), sizes[i]);
        for (size_t b = 0; b < sizes[i]; b++)
            snprintf(text + 2 * b, 3, "%02x", bytes[b]);
        assert_string_equal(text, hex[i]);
        link_packet back;
        assert_int_equal(ost_link_unseal(key, bytes, sizes[i], &back), LINK_GOOD);
        /* The encodings are compared instead of the structs, because padding between the members of a struct is
           undefined. */
        uint8_t again[LINK_STATE_BYTES] = {0}, first[LINK_STATE_BYTES] = {0};
        assert_int_equal(ost_link_encode(&back, again), ost_link_encode(&p, first));
        assert_memory_equal(again, first, sizeof first);
    }
    ost_link_key_free(key);
}

static void invalid_packets_are_refused(void **state)
{
    (void)state;
    link_key *key = key_from(1), *other = key_from(2);
    const uint8_t types[] = {LINK_POSE, LINK_STATE};
    for (int i = 0; i < 2; i++) {
        uint8_t bytes[LINK_STATE_BYTES + 1] = {0};
        link_packet p = golden(types[i]), back;
        const size_t size = ost_link_seal(key, &p, bytes);
        assert_int_equal(ost_link_unseal(other, bytes, size, &back), LINK_WRONG_KEY);
        /* Changing any bit makes the packet invalid. */
        for (size_t bit = 0; bit < size * 8; bit++) {
            bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
            assert_int_not_equal(ost_link_unseal(key, bytes, size, &back), LINK_GOOD);
            bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        }
        for (size_t n = 0; n < size; n++)
            assert_int_equal(ost_link_unseal(key, bytes, n, &back), LINK_MALFORMED);
        assert_int_equal(ost_link_unseal(key, bytes, size + 1, &back), LINK_MALFORMED);
        /*
         * These packets are signed correctly but have invalid contents: a quaternion that is not a
         * rotation, a position beyond 8 m, an unknown flag or type, or an invalid tool number.
         */
        link_packet bad = p;
        bad.pose.qw = 0;
        assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_MALFORMED);
        bad = p;
        bad.pose.t.y = OST_LENGTH_MAX + 1;
        assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_MALFORMED);
        bad = p;
        bad.flags |= 0x100;
        assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_MALFORMED);
        bad = p;
        bad.type = 4;
        assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_MALFORMED);
    }
    link_packet bad = golden(LINK_POSE), back;
    uint8_t bytes[LINK_STATE_BYTES];
    bad.tool = -2;
    assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_MALFORMED);
    /* If the tool is not held, its pose is not checked. */
    bad = golden(LINK_POSE);
    bad.flags = 0;
    bad.pose.qw = 0;
    assert_int_equal(ost_link_unseal(key, bytes, ost_link_seal(key, &bad, bytes), &back), LINK_GOOD);
    ost_link_key_free(key);
    ost_link_key_free(other);
}

static void key_files(void **state)
{
    (void)state;
    ost_error err = {0};
    link_key *key;
    char *folder = scratch_folder();
    static uint8_t bytes[5000];
    const char *file = scratch_write(folder, "open.key", bytes, 32);
    assert_int_equal(chmod(file, 0640), 0);
    assert_int_equal(ost_link_key_read(file, &key, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "open.key: other users can read this key"));
    assert_int_equal(chmod(file, 0600), 0);
    assert_ok(ost_link_key_read(file, &key, &err));
    ost_link_key_free(key);
    file = scratch_write(folder, "short.key", bytes, 15);
    assert_int_equal(chmod(file, 0600), 0);
    assert_int_equal(ost_link_key_read(file, &key, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "short.key: the key has 15 bytes; expected 16 to 4096"));
    file = scratch_write(folder, "long.key", bytes, 5000);
    assert_int_equal(chmod(file, 0600), 0);
    assert_int_equal(ost_link_key_read(file, &key, &err), OST_ERR_INPUT);
    assert_null(key);
    assert_int_equal(ost_link_key_read("/nowhere/a.key", &key, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "to create a key"));
    scratch_remove(folder);
}

static void sequence_numbers_are_classified(void **state)
{
    (void)state;
    link_window w = {0};
    uint64_t lost;
    assert_int_equal(ost_link_window_add(&w, 1, &lost), LINK_NEW);
    assert_int_equal(lost, 0);
    assert_int_equal(ost_link_window_add(&w, 1, &lost), LINK_REPLAYED);
    assert_int_equal(ost_link_window_add(&w, 5, &lost), LINK_NEW);
    assert_int_equal(lost, 3);
    assert_int_equal(ost_link_window_add(&w, 3, &lost), LINK_LATE);
    assert_int_equal(ost_link_window_add(&w, 3, &lost), LINK_REPLAYED);
    assert_int_equal(ost_link_window_add(&w, 5, &lost), LINK_REPLAYED);
    assert_int_equal(ost_link_window_add(&w, 68, &lost), LINK_NEW);
    assert_int_equal(ost_link_window_add(&w, 5, &lost), LINK_REPLAYED);
    /* A packet whose sequence number is 64 behind the newest is treated as a duplicate. */
    assert_int_equal(ost_link_window_add(&w, 4, &lost), LINK_REPLAYED);
    assert_int_equal(ost_link_window_add(&w, 6, &lost), LINK_LATE);
    assert_int_equal(ost_link_window_add(&w, UINT64_MAX, &lost), LINK_NEW);
    assert_int_equal(lost, UINT64_MAX - 69);
    assert_int_equal(ost_link_window_add(&w, 0, &lost), LINK_REPLAYED);
    assert_int_equal(ost_link_window_add(&w, UINT64_MAX - 63, &lost), LINK_LATE);
}

static void plane_never_attracts_the_device(void **state)
{
    (void)state;
    /* The state contains a force of 2 N along +z at z = 1 mm, a stiffness of 300 N/m and a damping of 0.5 N s/m. */
    link_packet s = golden(LINK_STATE);
    double f[3];
    s.pose.t = (ost_pm3){0, 0, OST_PM_PER_MM};
    memcpy(s.force_un, (int32_t[3]){0, 0, 2000000}, sizeof s.force_un);
    ost_bridge_press(&s, (double[3]){0, 0, 1e-3}, (double[3]){0}, 1000, f);
    assert_true(f[0] == 0 && f[1] == 0 && fabs(f[2] - 2) < 1e-12);
    /* The device is 2 mm deeper than in the state and displaced along the plane. */
    ost_bridge_press(&s, (double[3]){0.5, -0.2, -1e-3}, (double[3]){0}, 1000, f);
    assert_true(fabs(f[2] - 2.6) < 1e-9 && f[0] == 0);
    /* The device moves inward at 0.2 m/s. */
    ost_bridge_press(&s, (double[3]){0, 0, 1e-3}, (double[3]){1, 0, -0.2}, 1000, f);
    assert_true(fabs(f[2] - 2.1) < 1e-9);
    ost_bridge_press(&s, (double[3]){0, 0, -1e-3}, (double[3]){0}, 100, f); /* The device allows only 100 N/m. */
    assert_true(fabs(f[2] - 2.2) < 1e-9);
    /* The device is outside the bone. */
    ost_bridge_press(&s, (double[3]){0, 0, 1e-3 + 0.0067}, (double[3]){0}, 1000, f);
    assert_true(f[2] == 0);
    memset(s.force_un, 0, sizeof s.force_un);
    ost_bridge_press(&s, (double[3]){0, 0, -1}, (double[3]){0}, 1000, f);
    assert_true(f[0] == 0 && f[1] == 0 && f[2] == 0);
}

/*
 * Presses the simulated device, in a light grip and without friction, against a wall of 300 N/m
 * whose force is delayed. Returns the range of motion in the last second, in m.
 */
static double range_with_delay(int delay, bool plane)
{
    enum { TICKS = 3000, LATE_MOST = 64 };
    ost_error err = {0};
    ost_path path;
    ost_haptic *device;
    ost_safety safety;
    link_packet states[LATE_MOST];
    memset(states, 0, sizeof states);
    assert_ok(ost_path_init(&path, TICKS, &err));
    for (int i = 0; i < TICKS; i++) /* The wall begins at z = 0. Within a second, the target moves to z = -5 mm. */
        path.ticks[i] = (ost_tick){
            .t_ns = (int64_t)i * 1000000,
            .rpm = OST_RPM_ON,
            .pose = {.t = {0, 0, 2 * OST_PM_PER_MM - (i < 1000 ? i : 1000) * 7 * OST_PM_PER_MM / 1000},
                     .qw = OST_Q30_ONE}};
    assert_ok(ost_haptic_open("sim:grip=light,friction=0", &(ost_haptic_setup){.path = &path}, &device, &err));
    ost_safety_begin(&safety, NULL);
    double last = 0, speed = 0, low = 1, high = -1;
    bool begun = false;
    for (int i = 0; i < TICKS; i++) {
        ost_haptic_state hand;
        assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
        const double z = (double)hand.pose.t.z * 1e-12, now = begun ? (z - last) * 1e3 : 0;
        speed += 0.27 * (now - speed);
        last = z;
        begun = true;
        /* The state for this pose is computed now and used `delay` ticks later. */
        link_packet *s = &states[i % LATE_MOST];
        *s = (link_packet){.type = LINK_STATE, .pose = hand.pose, .stiffness = 300000, .damping = 500};
        s->force_un[2] = z < 0 ? (int32_t)(-300 * z * 1e6) : 0;
        const link_packet *came = &states[(i + LATE_MOST - delay) % LATE_MOST];
        ost_wrench w = {{0}, {0}};
        if (plane) {
            ost_bridge_press(came, (double[3]){0, 0, z}, (double[3]){0, 0, speed}, 700, w.force_n);
            ost_safety_step(&safety, &hand.pose, true, 0, 1e-3, w.force_n, w.torque_nm);
        } else {
            w.force_n[2] = came->force_un[2] * 1e-6;
        }
        ost_haptic_write(device, &w);
        low = i >= TICKS - 1000 ? fmin(low, z) : 1;
        high = i >= TICKS - 1000 ? fmax(high, z) : -1;
    }
    ost_haptic_close(device);
    ost_path_free(&path);
    return high - low;
}

static void delayed_loop_comes_to_rest(void **state)
{
    (void)state;
    for (int delay = 0; delay <= 50; delay += 5) {
        const double with = range_with_delay(delay, true);
        printf("# delay %d ms: range of motion %.3f mm\n", delay, with * 1e3);
        assert_true(with < 0.2e-3); /* The range is less than four encoder steps. */
    }
    /* If the delayed force is used directly, without the plane, the device must oscillate. */
    const double without = range_with_delay(20, false);
    printf("# delay 20 ms, without the plane: range of motion %.1f mm\n", without * 1e3);
    assert_true(without > 2e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_as_documented),
        cmocka_unit_test(invalid_packets_are_refused),
        cmocka_unit_test(key_files),
        cmocka_unit_test(sequence_numbers_are_classified),
        cmocka_unit_test(plane_never_attracts_the_device),
        cmocka_unit_test(delayed_loop_comes_to_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
