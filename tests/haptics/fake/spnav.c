/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stand-in for libspnav. It has only the functions that the driver calls. Its events come from a feed
 * that the test fills. Its socket is one end of a pair; the other end represents the daemon. If FAKE_SHORT
 * is defined, the last function is missing.
 */
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "haptics/fake/fake.h"

#define EXPORT __attribute__((visibility("default")))

EXPORT fake_note fake_spnav;
EXPORT fake_feed fake_spnav_feed;

static int pair[2] = {-1, -1};

EXPORT int spnav_open(void);
EXPORT int spnav_close(void);
EXPORT int spnav_fd(void);
EXPORT int spnav_poll_event(void *event);

int spnav_open(void)
{
    fake_call(&fake_spnav, 'o');
    return fake_spnav.fail_open ? -1 : socketpair(AF_UNIX, SOCK_STREAM, 0, pair);
}

int spnav_close(void)
{
    fake_call(&fake_spnav, 'c');
    for (int i = 0; i < 2; i++)
        if (pair[i] >= 0)
            close(pair[i]);
    pair[0] = pair[1] = -1;
    return 0;
}

int spnav_fd(void)
{
    return pair[0];
}

#ifndef FAKE_SHORT
int spnav_poll_event(void *event)
{
    const int at = fake_spnav_feed.taken;
    if (atomic_fetch_add(&fake_spnav.frames, 1) + 1 == fake_spnav.hang_at && pair[1] >= 0) {
        close(pair[1]); /* This simulates the termination of the daemon. */
        pair[1] = -1;
    }
    if (at == fake_spnav_feed.count)
        return 0;
    fake_spnav_feed.taken++;
    memcpy(event, fake_spnav_feed.event[at], sizeof fake_spnav_feed.event[at]);
    return fake_spnav_feed.event[at][0];
}
#endif
