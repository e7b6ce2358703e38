/* SPDX-License-Identifier: Apache-2.0 */
/* The landmarks of a scapula as lines over a picture (--overlay landmarks). */
#ifndef OST_APP_PICTURE_LANDMARKS_H
#define OST_APP_PICTURE_LANDMARKS_H

#include "render/viewer.h"
#include "render/views.h"

/* Stores trigonum and inferior angle in the subject if a bone's header contains both. */
ost_status landmarks_subject(const ost_meta *meta, ost_view_subject *subject, ost_error *err);

/*
 * Stores the landmarks of the subject, and the rim of the glenoid as found on the uncut bone, in the viewer's scene.
 * Returns OST_ERR_USAGE if the subject has no landmarks. If no rim is found, none is drawn.
 */
ost_status landmarks_show(const ost_view_subject *subject, ost_viewer *viewer, ost_error *err);

#endif
