/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The coordinate system that a mesh file states. STL, PLY and OBJ have no field for it. 3D Slicer writes and reads
 * the text SPACE=LPS or SPACE=RAS, in the header of an STL file and in a comment of a PLY or OBJ file
 * (vtkMRMLModelStorageNode). Other programs ignore this text.
 */
#ifndef OST_IO_MESH_FRAME_H
#define OST_IO_MESH_FRAME_H

#define OST_MESH_SPACE_LPS "SPACE=LPS"

typedef enum ost_mesh_frame {
    OST_MESH_OWN, /* coordinate system of a tool, which is independent of a patient; the file states nothing */
    OST_MESH_LPS  /* coordinate system of a CT or a bone */
} ost_mesh_frame;

#endif
