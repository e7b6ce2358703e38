/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The header fields by which 3D Slicer opens a NRRD as a segmentation instead of a CT: one group
 * SegmentN_... for each label (vtkMRMLSegmentationStorageNode). A name is Label N, unless the fact
 * segment_name_N states another one.
 */
#ifndef OST_IO_NRRD_SEGMENTS_H
#define OST_IO_NRRD_SEGMENTS_H

#include <osteon/grid.h>

/* The greatest number of segments that are described. A reader opens further labels without a name. */
enum { OST_NRRD_SEGMENTS_MAX = 255 };

/*
 * Returns the fields of the labels above 0 that occur in the volume, as lines that end with LF. The caller frees the
 * text; it is NULL if memory is lacking.
 */
char *ost_nrrd_segments(const ost_volume *volume);

#endif
