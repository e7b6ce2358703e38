/* SPDX-License-Identifier: Apache-2.0 */
/*
 * devices.json: the processor's instruction sets, and every OpenCL device that
 * the loader shows, with what its driver says of it, its numeric fingerprint
 * (what its integers and floats do when asked), and whether it was compared.
 * The same machine with the same drivers gives the same file.
 */
#ifndef OST_VALIDATION_DEVICES_H
#define OST_VALIDATION_DEVICES_H

#include <jansson.h>

#include "validation/subjects.h"

#define DEVICES_FILE "devices.json"

/* Opens OpenCL's devices only when one was among those to be compared. The caller's reference. */
ost_status devices_of(const subject_list *subjects, json_t **out, ost_error *err);

#endif
