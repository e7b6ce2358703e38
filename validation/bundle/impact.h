/* SPDX-License-Identifier: Apache-2.0 */
/*
 * impact.json: the changes between an older bundle and this one, and their known
 * causes.
 *
 *   old/, new folder --bundle_difference--> results of the reference by case, stage and chunk
 *                    --cases.jsonl--------> verdicts of backends that both have
 *                    --tools, devices-----> commit, compiler, flags, program, libraries, drivers
 *                    --requirements.csv---> added, removed, changed
 *
 * The older bundle is read and not checked (osteon verify does that).  Its root
 * is recorded, so that impact.json identifies that bundle.
 */
#ifndef OST_VALIDATION_IMPACT_H
#define OST_VALIDATION_IMPACT_H

#include <jansson.h>
#include <osteon/status.h>

#define IMPACT_FILE "impact.json"

/* Returns OST_ERR_INPUT if the folder is not a bundle; called before anything runs. */
ost_status impact_check(const char *old, ost_error *err);

/*
 * Makes the content of impact.json, owned by the caller:
 * {against {root, results_root, version}, results (bundle_difference), verdicts[] {case, backend, old, new},
 *  causes[] {what, old, new}, libraries[], devices[], requirements[], explained, conclusion}.
 */
ost_status impact_of(const char *old, const char *now, json_t **out, ost_error *err);

#endif
