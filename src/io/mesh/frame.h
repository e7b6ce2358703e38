/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coordinate systems that a mesh file can state. STL, PLY and OBJ have no field for the coordinate system, so 3D Slicer
 * writes and reads the text SPACE=LPS or SPACE=RAS, in the header of an STL file or in a comment of a PLY or OBJ file
 * (vtkMRMLModelStorageNode). Other programs ignore this text.
 */
#ifndef OST_IO_MESH_FRAME_H
#define OST_IO_MESH_FRAME_H

#define OST_MESH_SPACE_LPS "SPACE=LPS"

typedef enum ost_mesh_frame {
    OST_MESH_OWN, /* coordinate system of a tool, which does not refer to a patient; not stated in the file */
    OST_MESH_LPS  /* coordinate system of a CT or a bone */
} ost_mesh_frame;

#endif
