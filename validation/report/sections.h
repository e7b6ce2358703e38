/* SPDX-License-Identifier: Apache-2.0 */
/* The page's larger parts, each a function of the page alone. */
#ifndef OST_VALIDATION_REPORT_SECTIONS_H
#define OST_VALIDATION_REPORT_SECTIONS_H

#include "validation/report/page.h"

/* When and where the campaign ran: nothing without environment.json. */
void section_machine(const page *p);
/* Paths that each backend counted, and those that no case entered; nothing where none counted. */
void section_paths(const page *p);
/* Writes the changes since an older bundle; nothing without impact.json. */
void section_changes(const page *p);
/* What was compared with what: backends by families of cases. */
void section_compared(const page *p);
/* Which files of the user's own are the cases user/1 and on; nothing without them. */
void section_own_files(const page *p);
/* What the reference made: stages and their records. */
void section_reference(const page *p);
/* Each result that is not equal, with pictures where the campaign kept them. */
void section_differences(const page *p);
/* How near the decisions were that differ, by backend and stage; nothing where no voxel differs. */
void section_margins(const page *p);
/* Deliberate mistakes and whether they were noticed; nothing without sensitivity.json. */
void section_sensitivity(const page *p);
/* Checks against what is known without any program; nothing without common.json. */
void section_common(const page *p);
/* Build, program, devices, libraries; nothing without tools.json. */
void section_made_with(const page *p);
/* How many are tested, shown, orphans; nothing without trace.csv. */
void section_requirements(const page *p);
/* The tests that requirements name, and how they came out; nothing without suite.json. */
void section_suite(const page *p);

#endif
