/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs every stage of one case on one backend and writes the results into the
 * trace. Only the files perform*.c call the stages of a backend under test.
 *
 *   samples --ct_to_rect--> rect --rect_to_cubic--> cubic --cubic_to_chunks--> bone
 *   snapped mesh --voxelize--> tool             tick --ost_world_step--> report, changed leaves
 *
 * A stage that fails writes TRACE_FAILED with its status and ends the case. The status is recorded because
 * two backends must refuse the same inputs with the same status.
 *
 * The function perform_apart does not propagate a difference to later stages: it records the result of each stage and
 * replaces it with the reference's result before the next stage.
 *
 *   given rect --rect_to_cubic--> cubic   given cubic --cubic_to_chunks--> bone
 *   given tool, the reference's bone before the tick --ost_world_step--> report, changed leaves
 */
#ifndef OST_VALIDATION_PERFORM_H
#define OST_VALIDATION_PERFORM_H

#include "validation/scene.h"
#include "validation/trace.h"

/* maximum number of voxels of a bone that is downloaded after every tick (perform_tick.c) */
enum { PERFORM_ALL_VOXELS = 1 << 18 };

/* Called after each record is written. NULL may be passed to perform instead of a callback. */
typedef void perform_watch(void *user, trace_stage stage, uint32_t item);

/* Runs a case. Stores the error line of a failed stage in *why; why must not be NULL. The function itself fails only
   if the trace cannot be written or memory is exhausted. */
ost_status perform(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, perform_watch *watch,
                   void *user, ost_error *why, ost_error *err);

/*
 * Runs a case with the steps of the second implementation in place of those of src/core and src/sim
 * (steps_make.h). The steps are snapped meshes, ticks of a motor, events, poses and maps. If a case would
 * take too long, only the steps of its ticks are computed.
 */
ost_status perform_second(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, ost_error *why,
                          ost_error *err);

/* Runs a case with the reference's results as the input of each stage. The reference's trace `given` must contain
   this case completely. */
ost_status perform_apart(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, const trace *given,
                         ost_error *why, ost_error *err);

#endif
