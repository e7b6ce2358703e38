/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes devices.json, which lists the processor's instruction sets and every OpenCL device that the OpenCL
 * loader finds. For each device, the file contains the driver's description, a numeric fingerprint (results of
 * integer and float operations on the device), and whether the campaign compared the device with the
 * reference. The same machine with the same drivers gives the same file.
 */
#ifndef OST_VALIDATION_DEVICES_H
#define OST_VALIDATION_DEVICES_H

#include <jansson.h>

#include "validation/subjects.h"

#define DEVICES_FILE "devices.json"

/* Makes the content of devices.json; the caller owns *out. OpenCL devices are opened only if a subject is an OpenCL
   device. */
ost_status devices_of(const subject_list *subjects, json_t **out, ost_error *err);

#endif
