/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_APP_VERBS_INFO_DICOM_H
#define OST_APP_VERBS_INFO_DICOM_H

#include "app/common/app.h"

/*
 * Lists the series of a folder of DICOM files. If the options select one series that can be read, sets *found to true
 * and *geometry to its geometry. Returns OST_ERR_INPUT if no file is DICOM.
 */
ost_status info_dicom(const app_state *app, const char *name, const ost_volume_options *options, bool *found,
                      ost_geometry *geometry, ost_error *err);

#endif
