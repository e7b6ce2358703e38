/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the landmarks of a scapula as lines over a picture (--overlay landmarks). */
#ifndef OST_APP_PICTURE_LANDMARKS_H
#define OST_APP_PICTURE_LANDMARKS_H

#include "render/viewer.h"
#include "render/views.h"

/* Stores the trigonum and the inferior angle in the subject if the header of a bone contains both landmarks. */
ost_status landmarks_subject(const ost_meta *meta, ost_view_subject *subject, ost_error *err);

/*
 * Adds the landmarks of the subject, and the rim of the glenoid as found on the uncut bone, to the viewer's scene. If
 * no rim is found, only the landmarks are drawn. Returns OST_ERR_USAGE if the subject has no landmarks.
 */
ost_status landmarks_show(const ost_view_subject *subject, ost_viewer *viewer, ost_error *err);

#endif
