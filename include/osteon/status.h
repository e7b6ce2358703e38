/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Statuses and error messages.
 *
 * Every function that can fail returns an ost_status and takes an ost_error* as its last argument.
 * The error contains one line of text for the user: the file, the line or offset, the wrong value,
 * and the expected value.  The ost_error pointer may always be NULL; the text is then discarded.
 *
 * Threads: an ost_error belongs to its caller; the functions here share no state.
 */
#ifndef OSTEON_STATUS_H
#define OSTEON_STATUS_H

#include <stdbool.h>

#if defined __GNUC__
#define OST_API __attribute__((visibility("default")))
#define OST_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define OST_API
#define OST_PRINTF(fmt, args)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The list of statuses. Each entry has the form X(name, exit status of the command, general text).
 *
 *   OST_OK               done
 *   OST_ERR_DIFFER       a check failed or two grids differ
 *   OST_ERR_USAGE        the caller's arguments are wrong
 *   OST_ERR_INPUT        the content of a file is wrong; the text contains the position
 *   OST_ERR_RANGE        a value is outside the range for which docs/spec/arithmetic.md
 *                        proves its results; the text contains the value and the bound
 *   OST_ERR_IO           the system failed to read or write; the text contains the reason
 *   OST_ERR_MEMORY       an allocation failed; the text contains its size or purpose
 *   OST_ERR_UNAVAILABLE  not available in this build or on this machine; the text
 *                        contains the reason or the package to install
 *   OST_ERR_CANCELLED    a progress callback cancelled the operation
 *   OST_ERR_INTERNAL     a defect in osteon itself
 */
#define OST_STATUS_LIST(X)                                   \
    X(OST_OK, 0, "done")                                     \
    X(OST_ERR_DIFFER, 1, "the check failed")                 \
    X(OST_ERR_USAGE, 2, "wrong usage")                       \
    X(OST_ERR_INPUT, 2, "bad input")                         \
    X(OST_ERR_RANGE, 2, "value out of the supported range")  \
    X(OST_ERR_IO, 2, "input or output failed")               \
    X(OST_ERR_MEMORY, 2, "out of memory")                    \
    X(OST_ERR_UNAVAILABLE, 3, "not available here")          \
    X(OST_ERR_CANCELLED, 2, "cancelled")                     \
    X(OST_ERR_INTERNAL, 2, "defect in osteon")

/* The result of a function that can fail. */
typedef enum ost_status {
#define OST_STATUS_ENUM(name, exit_status, text) name,
    OST_STATUS_LIST(OST_STATUS_ENUM)
#undef OST_STATUS_ENUM
} ost_status;

/*
 * Called from time to time with the completed share of the work, from 0 to 1. Returns false to cancel the
 * operation; the operation then returns OST_ERR_CANCELLED.
 */
typedef bool ost_progress(void *user, const char *stage, double share);

enum { OST_ERROR_TEXT = 640 };

/* An error message: one line without a newline, always NUL-terminated. Zero-initialise the struct before use. */
typedef struct ost_error {
    ost_status status;
    char text[OST_ERROR_TEXT];
} ost_error;

/* Returns the name of the enumerator, for example "OST_ERR_INPUT"; never NULL. */
OST_API const char *ost_status_name(ost_status status);
/* Returns the general text of the status, for example "bad input"; never NULL. */
OST_API const char *ost_status_text(ost_status status);
/* Returns the exit status of the `osteon` command for this status: 0, 1, 2 or 3. */
OST_API int ost_status_exit(ost_status status);

/*
 * If err is not NULL, writes the status and the text to err. Returns status, so that a failing function can end
 * with `return ost_fail(err, OST_ERR_INPUT, "%s:%ld: ...", path, line)`. Characters that would break the line or
 * control a terminal (control and direction characters, bytes that are not valid UTF-8) are replaced by '?'.
 */
OST_API ost_status ost_fail(ost_error *err, ost_status status, const char *format, ...) OST_PRINTF(3, 4);

/*
 * Inserts "prefix: " before the text in err. Returns the status that err contains, or OST_ERR_INTERNAL if err is
 * NULL.
 */
OST_API ost_status ost_fail_context(ost_error *err, const char *format, ...) OST_PRINTF(2, 3);

/*
 * The version of these headers.  Version 0.2.0 is the integer OST_VERSION_NUMBER(0, 2, 0), so that the
 * preprocessor can compare versions: #if OST_VERSION >= OST_VERSION_NUMBER(0, 2, 0).
 */
#define OST_VERSION_MAJOR 0
#define OST_VERSION_MINOR 2
#define OST_VERSION_PATCH 0
#define OST_VERSION_NUMBER(major, minor, patch) ((major) * 1000000 + (minor) * 1000 + (patch))
#define OST_VERSION OST_VERSION_NUMBER(OST_VERSION_MAJOR, OST_VERSION_MINOR, OST_VERSION_PATCH)

/* Returns the version of the loaded library, for example "0.2.0"; static, never NULL. */
OST_API const char *ost_version(void);
/* Returns the version of the loaded library as an OST_VERSION_NUMBER. */
OST_API int ost_version_number(void);
/* The version of docs/spec/arithmetic.md that this library implements. */
enum { OST_ARITHMETIC_VERSION = 2 };

#ifdef __cplusplus
}
#endif
#endif
