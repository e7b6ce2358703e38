/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs work on all cores after the simulator has reserved one core for its servo loop.
 *
 * The simulator reserves the core before it creates threads, because a thread inherits the set of cores of its creator.
 * Work that ends before the servo loop begins, such as generating a bone, may also use the reserved core. This work
 * runs on a separate thread, so that its OpenMP threads end with it.
 */
#ifndef OST_APP_COMMON_ALL_CORES_H
#define OST_APP_COMMON_ALL_CORES_H

/* Records the cores on which this process may run. Called once, before any thread is created. */
void all_cores_begin(void);
/* Calls work(user) on a new thread that may run on all recorded cores, and waits until the thread has ended. If no
   thread can be created, calls work(user) on the calling thread. */
void all_cores_do(void (*work)(void *user), void *user);

#endif
