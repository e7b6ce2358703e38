/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Formats the header fields that make 3D Slicer open a NRRD file as a segmentation instead of a CT: a group of fields
 * SegmentN_... for each label (vtkMRMLSegmentationStorageNode). The name of label N is "Label N", unless the header
 * fact segment_name_N states another name.
 */
#ifndef OST_IO_NRRD_SEGMENTS_H
#define OST_IO_NRRD_SEGMENTS_H

#include <osteon/grid.h>

/* Maximum number of segments for which fields are written. Programs show further labels without a name. */
enum { OST_NRRD_SEGMENTS_MAX = 255 };

/*
 * Returns the fields for all labels above 0 that occur in the volume, as lines that end with LF. The caller frees the
 * text. Returns NULL if memory is exhausted.
 */
char *ost_nrrd_segments(const ost_volume *volume);

#endif
