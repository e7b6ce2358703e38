// SPDX-License-Identifier: Apache-2.0
//
// Declarations of osteon-dicom, the process that parses DICOM files for the library (../protocol.h).
//
//   main.cpp      reads the request, writes the messages
//   scan.cpp      the attributes of the images of a file
//   pixels.cpp    the pixels of an image
//   stream_size.cpp  the size of a compressed frame
//   jpeg2000.cpp  the decoder for JPEG 2000, which DCMTK does not have
//
// Only this process calls DCMTK and OpenJPEG. It writes only messages, and only to standard output. The log of DCMTK is
// disabled, because it may quote the files. Before the process starts, the library limits its memory, its time and its
// descriptors.
#ifndef OST_IO_DICOM_CHILD_H
#define OST_IO_DICOM_CHILD_H

#include <cstddef>
#include <vector>

#include <dcmtk/config/osconfig.h>

#include <dcmtk/dcmdata/dcfcache.h>
#include <dcmtk/dcmdata/dctk.h>

#include "io/dicom/protocol.h"

// Writes a message. Ends the process if the library has closed the pipe.
void send_message(ost_dicom_type type, uint32_t index, const void *payload, size_t size);

// Loads a file without its long values. DCMTK later reads a long value when it is needed.
ost_dicom_result load_file(const char *path, DcmFileFormat &file);

// Returns OK if the pixels of the data set's transfer syntax can be decoded.
ost_dicom_result check_syntax(const DcmFileFormat &file, char uid[OST_DICOM_TEXT]);

// Returns true if the pixels of the transfer syntax are fragments. DCMTK renamed its own function after 3.6.7.
bool is_encapsulated(const char *uid);

// Sends a FRAME message for every image of the file. Returns the result for the FILE message that follows.
ost_dicom_result scan_file(const char *path, uint32_t index, const uint8_t salt[OST_DICOM_SALT]);

// The file whose image was read last. The file remains loaded for its next image.
struct open_file {
    DcmFileFormat file;
    DcmFileCache cache;
    const char *path = nullptr;
    Uint32 next_frame = 0, next_fragment = 0; // the next frame and its first fragment, if frames are read in order
};

// Reads an image of the file as cells of 16 bits. `cells` is resized to columns * rows.
ost_dicom_result read_image(open_file &from, const char *path, const ost_dicom_image &image,
                            std::vector<uint16_t> &cells);

// Functions that return true if a compressed frame has the given size. `bytes` is the number of bytes per pixel.
bool is_rle_of_size(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows, uint32_t bytes);
bool is_jpeg_of_size(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows, uint32_t bytes);

// Decodes a code stream of JPEG 2000 with one component of columns * rows samples of at most 16 bits.
ost_dicom_result decode_jpeg2000(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows,
                                 uint16_t *cells);

#endif
