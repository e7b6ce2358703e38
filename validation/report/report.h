/* SPDX-License-Identifier: Apache-2.0 */
/*
 * report.html: the evidence for readers, on one page that needs no other file.
 *
 *   protocol, cases, files of the folder (pictures, sensitivity.json) --report_write--> report.html
 *
 * It is derived only from the bundle's files, without times or the machine's
 * name, so a check of the bundle derives it again and compares bytes.  It is
 * written last, because it names optional files only if they are in the folder.
 */
#ifndef OST_VALIDATION_REPORT_H
#define OST_VALIDATION_REPORT_H

#include "validation/bundle/evidence.h"

#define REPORT_FILE "report.html"

ost_status report_write(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                        void *user, ost_error *err);

#endif
