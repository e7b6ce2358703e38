/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Encodes and decodes the packets that a simulation and a bridge exchange.
 * docs/reference/devices.md, section "udp", documents every byte. All packets have fixed sizes, are
 * little-endian, and end in an HMAC-SHA-256 of the preceding bytes with a key that both sides
 * share.
 *
 *   bridge --hello, pose--> simulation          one packet each, 120 bytes
 *   bridge <----state------ simulation          the answer, 144 bytes
 *
 * No function in this file waits. The only stored state is the key's context. Sequence numbers are
 * checked with a link_window.
 */
#ifndef OST_HAPTICS_LINK_H
#define OST_HAPTICS_LINK_H

#include <osteon/haptics.h>

enum {
    LINK_VERSION = 1,
    LINK_MAC = 32,
    LINK_POSE_BYTES = 120,  /* size of a hello packet or a pose packet */
    LINK_STATE_BYTES = 144,
    LINK_BUFFER_BYTES = 256, /* size of the receive buffer; any longer packet is invalid */
    LINK_KEY_MIN = 16,
    LINK_KEY_MAX = 4096
};

typedef enum link_type { LINK_HELLO = 1, LINK_POSE = 2, LINK_STATE = 3 } link_type;

enum {
    LINK_SEEN = 1,   /* flag of a pose packet: the device holds the tool */
    LINK_ENDED = 2,  /* flag of the last pose or state packet of a run */
    /* flag of a state packet: the pose was too far away, so the bridge must release its clutch and engage it again at
       the tool's position */
    LINK_AGAIN = 4,
    /* flag of a state packet: the simulation is already connected to another bridge */
    LINK_BUSY = 8
};

typedef struct link_packet {
    uint8_t type;
    uint16_t flags;
    /* random numbers that identify the two sides during this run; `simulation` is 0 in a hello packet */
    uint64_t bridge, simulation;
    uint64_t sequence;           /* sequence number of this packet, counted by the sender */
    /* in a state packet, the maximum sequence number of the poses that the simulation has accepted */
    uint64_t answers;
    /* in a hello or pose packet, the time on the sender's clock, only for diagnosis */
    int64_t t_ns;
    /* in a hello or pose packet, the pose of the device; in a state packet, the pose at which the force was computed */
    ost_pose pose;
    uint32_t buttons;
    int32_t tool;                /* index of the selected tool; -1 if the device does not select a tool */
    int32_t force_un[3], torque_unm[3];
    uint32_t stiffness, damping; /* stiffness in mN/m and damping in mN s/m along the force */
} link_packet;

/* The result of checking received bytes. */
typedef enum link_verdict { LINK_GOOD, LINK_MALFORMED, LINK_WRONG_KEY } link_verdict;

/*
 * ost_link_encode and ost_link_decode convert between a packet and its bytes without the HMAC. ost_link_decode checks
 * the size, the magic number, the version and the type. It also checks that unused flags are 0, and that pose and tool
 * are valid.
 */
size_t ost_link_encode(const link_packet *packet, uint8_t bytes[LINK_STATE_BYTES]);
bool ost_link_decode(const uint8_t *bytes, size_t size, link_packet *out);

/* ------------------------------------------------------------------- keys */

typedef struct link_key link_key;

/*
 * ost_link_key_read reads a key from a file, and ost_link_key_make copies a key from memory. Both return OST_ERR_INPUT
 * if the key has too few or too many bytes. ost_link_key_read returns OST_ERR_USAGE if users other than the file's
 * owner may read the file.
 */
ost_status ost_link_key_read(const char *path, link_key **out, ost_error *err);
ost_status ost_link_key_make(const void *bytes, size_t size, link_key **out, ost_error *err);
void ost_link_key_free(link_key *key); /* NULL is allowed */

/*
 * ost_link_seal encodes a packet and appends the HMAC; it returns 0 if libcrypto fails. ost_link_unseal checks the HMAC
 * and decodes a packet. A key may be used by only one thread at a time.
 */
size_t ost_link_seal(link_key *key, const link_packet *packet, uint8_t bytes[LINK_STATE_BYTES]);
link_verdict ost_link_unseal(link_key *key, const uint8_t *bytes, size_t size, link_packet *out);

/* ---------------------------------------------------------------- numbers */

/* Records, for the 64 highest sequence numbers of a sender, which packets have arrived. */
typedef struct link_window {
    /* `last` is the newest sequence number; bit i of `seen` is set if packet last - i has arrived */
    uint64_t last, seen;
} link_window;

typedef enum link_order { LINK_NEW, LINK_LATE, LINK_REPLAYED } link_order;

/*
 * Adds a packet to the window. Returns LINK_NEW if the packet is newer than all previous packets;
 * *lost is then the number of skipped sequence numbers. Returns LINK_LATE if the packet arrived
 * after newer packets, and LINK_REPLAYED if the packet was received before or is too old to be
 * checked.
 */
link_order ost_link_window_add(link_window *window, uint64_t sequence, uint64_t *lost);

/* Reads a random number other than 0 from the system. Returns false if the system provides none. */
bool ost_link_random(uint64_t *out);

#endif
