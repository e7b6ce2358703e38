/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Packets between a simulation and a bridge: docs/haptics.md, "The link", has
 * every byte.  All fixed, little-endian, and each ends in an HMAC-SHA-256 of
 * what is before it by a key that both sides have.
 *
 *   bridge --hello, pose--> simulation          a packet each, 120 bytes
 *   bridge <----state------ simulation          the answer, 144 bytes
 *
 * Nothing here waits or keeps state but the key's; who judges numbers is
 * link_window.
 */
#ifndef OST_HAPTICS_LINK_H
#define OST_HAPTICS_LINK_H

#include <osteon/haptics.h>

enum {
    LINK_VERSION = 1,
    LINK_MAC = 32,
    LINK_POSE_BYTES = 120,  /* hello and pose */
    LINK_STATE_BYTES = 144,
    LINK_ROOM = 256,        /* what is received at most: anything longer is none of ours */
    LINK_KEY_MIN = 16,
    LINK_KEY_MAX = 4096
};

typedef enum link_type { LINK_HELLO = 1, LINK_POSE = 2, LINK_STATE = 3 } link_type;

enum {
    LINK_SEEN = 1,   /* pose: the hand holds the tool */
    LINK_ENDED = 2,  /* either: this is the last */
    LINK_AGAIN = 4,  /* state: the pose was too far off; let go, and take hold again where the tool is */
    LINK_BUSY = 8    /* state: another bridge has the simulation */
};

typedef struct link_packet {
    uint8_t type;
    uint16_t flags;
    uint64_t bridge, simulation; /* each side's number of this run, drawn at random; simulation is 0 in a hello */
    uint64_t sequence;           /* of the sender */
    uint64_t answers;            /* state: the greatest sequence that the simulation took */
    int64_t t_ns;                /* hello, pose: the sender's clock, for whoever looks at packets */
    ost_pose pose;               /* of the device; state: the one that was answered */
    uint32_t buttons;
    int32_t tool;                /* -1: it does not say */
    int32_t force_un[3], torque_unm[3];
    uint32_t stiffness, damping; /* mN/m and mN s/m, along the force */
} link_packet;

/* What can be wrong with bytes that came. */
typedef enum link_verdict { LINK_GOOD, LINK_MALFORMED, LINK_WRONG_KEY } link_verdict;

/* Bytes without their HMAC. decode checks size, magic, version, type, that unused flags are 0, and what must be a pose or a tool. */
size_t link_encode(const link_packet *packet, uint8_t bytes[LINK_STATE_BYTES]);
bool link_decode(const uint8_t *bytes, size_t size, link_packet *out);

/* ------------------------------------------------------------------- keys */

typedef struct link_key link_key;

/* OST_ERR_INPUT when the file has too few or too many bytes, OST_ERR_USAGE when others than its owner may read it. */
ost_status link_key_read(const char *path, link_key **out, ost_error *err);
ost_status link_key_make(const void *bytes, size_t size, link_key **out, ost_error *err);
void link_key_free(link_key *key); /* NULL is allowed */

/* With the HMAC. One thread at a time for each key. 0 when libcrypto fails. */
size_t link_seal(link_key *key, const link_packet *packet, uint8_t bytes[LINK_STATE_BYTES]);
link_verdict link_unseal(link_key *key, const uint8_t *bytes, size_t size, link_packet *out);

/* ---------------------------------------------------------------- numbers */

/* Which of a sender's packets came: the last and the 64 before it. */
typedef struct link_window {
    uint64_t last, seen; /* bit i: last - i came */
} link_window;

typedef enum link_order { LINK_NEW, LINK_LATE, LINK_REPLAYED } link_order;

/* LINK_NEW is newer than all before, with *lost numbers left out; LINK_LATE came after newer ones; LINK_REPLAYED was there, or is too old to know. */
link_order link_window_add(link_window *window, uint64_t sequence, uint64_t *lost);

/* A number of the system's randomness, never 0. False when it gives none. */
bool link_random(uint64_t *out);

#endif
