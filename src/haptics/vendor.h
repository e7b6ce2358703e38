/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loads a vendor's library only when a device that needs it is requested.
 *
 *   file --dlopen--> all symbols, or none
 *
 * An environment variable may name the file. Otherwise, the file is the first library that dlopen finds under one of
 * the given names.
 *
 * The build needs no vendor files, because this project declares the prototypes itself. A library stays loaded, because
 * some libraries have threads that outlive their devices.
 */
#ifndef OST_HAPTICS_VENDOR_H
#define OST_HAPTICS_VENDOR_H

#include <stdbool.h>
#include <stddef.h>

typedef void vendor_function(void);

typedef struct vendor_symbol {
    const char *name;
    size_t offset; /* offset of the function pointer in the driver's table of functions */
} vendor_symbol;

typedef struct vendor_library {
    const char *variable;        /* environment variable; if it is set, its value replaces `names` */
    const char *const *names;    /* names that are passed to dlopen one after the other; the list ends with NULL */
    const char *product;         /* name of the product that the user must install; used in messages */
    const vendor_symbol *symbols;
    size_t count;
} vendor_library;

/* Fills the pointers in `table` and returns true. On failure, returns false and writes the reason. */
bool ost_vendor_load(const vendor_library *library, void *table, char reason[256]);

#endif
