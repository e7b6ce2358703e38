/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Builds the object that --json prints. Each function takes ownership of the value passed to it. If
 * memory is exhausted, the program ends with a message.
 */
#ifndef OST_APP_COMMON_RESULT_H
#define OST_APP_COMMON_RESULT_H

#include "app/common/app.h"

void put(json_t *object, const char *key, json_t *value);
void append(json_t *array, json_t *value);

void put_text(json_t *object, const char *key, const char *text);
void put_integer(json_t *object, const char *key, int64_t value);
void put_real(json_t *object, const char *key, double value);
void put_bool(json_t *object, const char *key, bool value);
void put_dims(json_t *object, const char *key, ost_dims dims);
/* Stores a position as [x, y, z] in millimetres. */
void put_mm3(json_t *object, const char *key, ost_pm3 value);
void put_mm(json_t *object, const char *key, ost_pm value);
void put_digest(json_t *object, const char *key, const ost_digest *digest);
/* Stores the report as the object "dicom". */
void put_dicom_report(json_t *object, const ost_dicom_report *report);
void put_meta(json_t *object, const char *key, const ost_meta *meta);

/* Computes the SHA-256 of a file, as the program sha256sum does. */
ost_status file_digest(const char *path, ost_digest *out, ost_error *err);

#endif
