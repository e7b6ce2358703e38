/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loads a vendor's library when a device is requested, and not before.
 *
 *   file in the environment variable, else each name in turn --dlopen--> every symbol, or none
 *
 * Building needs nothing of a vendor; the prototypes are this project's own.  A
 * library stays loaded, because some have threads that outlive their devices.
 */
#ifndef OST_HAPTICS_VENDOR_H
#define OST_HAPTICS_VENDOR_H

#include <stdbool.h>
#include <stddef.h>

typedef void vendor_function(void);

typedef struct vendor_symbol {
    const char *name;
    size_t offset; /* of the pointer in the driver's table of functions */
} vendor_symbol;

typedef struct vendor_library {
    const char *variable;        /* environment variable with a file to load instead */
    const char *const *names;    /* names passed to dlopen in this order; ends with NULL */
    const char *product;         /* the product to install, for messages */
    const vendor_symbol *symbols;
    size_t count;
} vendor_library;

/* Fills the pointers in `table` and returns true; otherwise returns false with the reason. */
bool vendor_load(const vendor_library *library, void *table, char reason[256]);

#endif
