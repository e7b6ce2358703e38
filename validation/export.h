/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the cases' inputs as files, for a program that runs the cases without being
 * linked to this one.  docs/spec/dumps.md describes the files.
 *
 *   plan --export_cases--> DIR/cases.json, DIR/import-0/case.json, samples.txt, tool-0.obj, tool-0.stl, path.csv, ...
 */
#ifndef OST_VALIDATION_EXPORT_H
#define OST_VALIDATION_EXPORT_H

#include "validation/plan.h"

/* Writes all cases of the plan to a folder, which must not exist yet. */
ost_status export_cases(const char *folder, const plan *p, ost_error *err);

#endif
