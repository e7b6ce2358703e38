/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A vendor's library, found when a device is asked for and not before.
 *
 *   variable's file, else one name after the other --dlopen--> every symbol, or none of it
 *
 * Nothing of a vendor is needed to build; prototypes are our own.  A library
 * stays loaded: some have threads that outlive their devices.
 */
#ifndef OST_HAPTICS_VENDOR_H
#define OST_HAPTICS_VENDOR_H

#include <stdbool.h>
#include <stddef.h>

typedef void vendor_function(void);

typedef struct vendor_symbol {
    const char *name;
    size_t offset; /* of the pointer in the driver's table */
} vendor_symbol;

typedef struct vendor_library {
    const char *variable;        /* of the environment: a file to take instead */
    const char *const *names;    /* as dlopen takes them; ends with NULL */
    const char *product;         /* what to install */
    const vendor_symbol *symbols;
    size_t count;
} vendor_library;

/* Fills table's pointers; else says why not. */
bool vendor_load(const vendor_library *library, void *table, char reason[256]);

#endif
