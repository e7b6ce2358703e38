/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes report.html, which presents the evidence on one page that needs no other file.
 *
 *   protocol, cases, files of the folder (pictures, sensitivity.json) --report_write--> report.html
 *
 * The report is derived only from the bundle's files; the date and the machine, too, are read from these files.
 * Therefore a check of the bundle can derive the report again and compare the bytes. The report is written last,
 * because it mentions an optional file only if the file is in the folder.
 */
#ifndef OST_VALIDATION_REPORT_H
#define OST_VALIDATION_REPORT_H

#include "validation/bundle/evidence.h"

#define REPORT_FILE "report.html"

ost_status report_write(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                        void *user, ost_error *err);

#endif
