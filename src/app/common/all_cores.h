/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Work on all cores after the simulator has reserved one for its servo loop.
 *
 * The simulator reserves the core before it creates threads, because a thread inherits the cores of the thread that
 * creates it. Work that ends before the servo loop begins, such as generating a bone, may use the reserved core: it
 * runs on a thread of its own, whose OpenMP threads end with it.
 */
#ifndef OST_APP_COMMON_ALL_CORES_H
#define OST_APP_COMMON_ALL_CORES_H

/* Records the cores on which this process may run. Called once, before any thread is created. */
void all_cores_begin(void);
/* Calls work(user) on a thread that may run on all of these cores, and waits. If no thread can be created, this thread
   does the work. */
void all_cores_do(void (*work)(void *user), void *user);

#endif
