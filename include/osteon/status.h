/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What can go wrong, and how it is said.
 *
 * Every function that can fail returns an ost_status and takes an ost_error*
 * as its last argument.  The error holds one line of text for people: the
 * file, the line or offset, the value that was wrong, and what was expected.
 * A NULL ost_error is allowed everywhere; only the text is lost.
 *
 * Threads: an ost_error belongs to its caller; nothing here is shared.
 */
#ifndef OSTEON_STATUS_H
#define OSTEON_STATUS_H

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
 * X(name, exit status of the command, text)
 *
 *   OST_OK               done
 *   OST_ERR_DIFFER       a check failed or two grids differ
 *   OST_ERR_USAGE        the caller's arguments are wrong
 *   OST_ERR_INPUT        a file's content is wrong; the text says where
 *   OST_ERR_RANGE        a value lies outside the range that docs/arithmetic.md
 *                        proves; the text gives value and bound
 *   OST_ERR_IO           the system refused to read or write; text has errno
 *   OST_ERR_MEMORY       no memory; the text has the size asked for
 *   OST_ERR_UNAVAILABLE  not built in, or not here; the text says what to install
 *   OST_ERR_CANCELLED    a progress callback asked to stop
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

typedef enum ost_status {
#define OST_STATUS_ENUM(name, exit_status, text) name,
    OST_STATUS_LIST(OST_STATUS_ENUM)
#undef OST_STATUS_ENUM
} ost_status;

enum { OST_ERROR_TEXT = 640 };

/* One line, no newline at its end, always terminated. Zero-initialise before use. */
typedef struct ost_error {
    ost_status status;
    char text[OST_ERROR_TEXT];
} ost_error;

/* The enumerator's own name, "OST_ERR_INPUT"; never NULL. */
OST_API const char *ost_status_name(ost_status status);
/* The general text of the status, "bad input"; never NULL. */
OST_API const char *ost_status_text(ost_status status);
/* The command's exit status for it: 0, 1, 2 or 3. */
OST_API int ost_status_exit(ost_status status);

/*
 * Fills err (when not NULL) and returns status, so that a failing function
 * ends with `return ost_fail(err, OST_ERR_INPUT, "%s:%ld: ...", path, line)`.
 * Characters of the input that would break the line or act on a terminal
 * (control and direction characters, bytes that are no UTF-8) become '?'.
 */
OST_API ost_status ost_fail(ost_error *err, ost_status status, const char *format, ...) OST_PRINTF(3, 4);

/* Puts "prefix: " before the text already in err; returns err's status (OST_ERR_INTERNAL when err is NULL). */
OST_API ost_status ost_fail_context(ost_error *err, const char *format, ...) OST_PRINTF(2, 3);

/* "0.1.0", and the version of docs/arithmetic.md that this library implements. */
OST_API const char *ost_version(void);
enum { OST_ARITHMETIC_VERSION = 2 };

#ifdef __cplusplus
}
#endif
#endif
