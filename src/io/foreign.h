/* SPDX-License-Identifier: Apache-2.0 */
/* Recognises file formats that osteon does not read, and names the program that converts each of them. */
#ifndef OST_IO_FOREIGN_H
#define OST_IO_FOREIGN_H

#include <stddef.h>

#include <osteon/status.h>

/*
 * Returns OST_ERR_INPUT if the first bytes of the file `path` are the signature of a format that
 * osteon does not read, otherwise OST_OK. The error message names the format and the program that
 * converts it.
 */
ost_status ost_refuse_foreign(const char *path, const unsigned char *head, size_t size, ost_error *err);

#endif
