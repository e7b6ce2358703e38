/* SPDX-License-Identifier: Apache-2.0 */
/*
 * impact.json: what changed between an older bundle and this one, and which
 * known cause there is.
 *
 *   old/, new folder --bundle_difference--> results of the reference by case, stage and chunk
 *                    --cases.jsonl--------> verdicts of backends that both have
 *                    --tools, devices-----> commit, compiler, flags, program, libraries, drivers
 *                    --requirements.csv---> added, removed, changed
 *
 * The older bundle is read and not checked (osteon verify does that); its root
 * is recorded, so impact.json names the bundle that it is about.
 */
#ifndef OST_VALIDATION_IMPACT_H
#define OST_VALIDATION_IMPACT_H

#include <jansson.h>
#include <osteon/status.h>

#define IMPACT_FILE "impact.json"

/* Returns OST_ERR_INPUT where the folder is no bundle: for a check before anything runs. */
ost_status impact_check(const char *old, ost_error *err);

/*
 * {against {root, results_root, version}, results (bundle_difference), verdicts[] {case, backend, old, new},
 *  causes[] {what, old, new}, libraries[], devices[], requirements[], explained, conclusion}; the caller's reference.
 */
ost_status impact_of(const char *old, const char *now, json_t **out, ost_error *err);

#endif
