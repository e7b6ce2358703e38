/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The cases' inputs as files, for a program that is to run them without being
 * linked to anything of ours: what docs/dumps.md describes from its other end.
 *
 *   plan --export_cases--> DIR/cases.json, DIR/import-0/case.json, samples.txt, tool-0.obj, tool-0.stl, path.csv, ...
 */
#ifndef OST_VALIDATION_EXPORT_H
#define OST_VALIDATION_EXPORT_H

#include "validation/plan.h"

/* The folder must not exist. */
ost_status export_cases(const char *folder, const plan *p, ost_error *err);

#endif
