/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decodes arbitrary bytes as packets of the link. The bytes must be rejected, or decode to a packet that
 * encodes to the same bytes. If an HMAC key is required, packets that do not match the key must be
 * rejected.
 */
#include "fuzz.h"

#include "haptics/link.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static link_key *key;
    static const uint8_t secret[LINK_KEY_MIN] = {1, 2, 3};
    link_packet p;
    uint8_t again[LINK_STATE_BYTES];
    if (!key)
        fuzz_require(ost_link_key_make(secret, sizeof secret, &key, NULL) == OST_OK);
    if (ost_link_decode(data, size, &p)) {
        fuzz_require(p.type >= LINK_HELLO && p.type <= LINK_STATE && p.tool >= -1);
        fuzz_require(p.type != LINK_STATE || ost_pose_check(&p.pose, NULL) == OST_OK);
        fuzz_require(!(p.type == LINK_POSE && (p.flags & LINK_SEEN)) || ost_pose_check(&p.pose, NULL) == OST_OK);
        fuzz_require(ost_link_encode(&p, again) == size && memcmp(again, data, size) == 0);
        fuzz_require(ost_link_seal(key, &p, again) == size + LINK_MAC);
        fuzz_require(ost_link_unseal(key, again, size + LINK_MAC, &p) == LINK_GOOD);
    }
    fuzz_require(ost_link_unseal(key, data, size, &p) != LINK_GOOD);
    return 0;
}

const char *const fuzz_words[] = {"OSTL", "\x01\x02", "\x01\x03", "\xff\xff\xff\xff", "\x40", NULL};

/* Makes two packets of each type, one without an HMAC and one with an HMAC that does not match the key. */
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index >= 6 || capacity < LINK_STATE_BYTES)
        return 0;
    const link_packet p = {.type = (uint8_t)(1 + index % 3),
                           .flags = index % 3 == 1 ? LINK_SEEN : 0,
                           .bridge = 5,
                           .simulation = index % 3 ? 6 : 0,
                           .sequence = 7,
                           .pose = {.t = {1, -2, 3}, .qw = OST_Q30_ONE}};
    const size_t size = ost_link_encode(&p, bytes);
    memset(bytes + size, 0x55, LINK_STATE_BYTES - size);
    return index < 3 ? size : size + LINK_MAC;
}
