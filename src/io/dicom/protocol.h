/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Defines the messages between the library and osteon-dicom, the process that parses DICOM files.
 *
 *   library --request: a file in memory as standard input--> osteon-dicom
 *   library <--messages: a pipe as standard output-- osteon-dicom
 *
 *   OST_DICOM_SCAN   request, paths               -> for each path: a FRAME for each of its images, then one FILE
 *   OST_DICOM_READ   request, paths, images       -> for each image: PIXELS; if an image cannot be read: FILE with the
 *                                                    reason, and no message for the remaining images
 *
 * The last message is END in both cases.
 *
 * A path is a uint32_t with its length in bytes, followed by its bytes without a NUL. Numbers are in native byte order,
 * because the library and osteon-dicom are built together. The field `version` differs if osteon-dicom is from a
 * different build.
 *
 * The library checks everything that it receives: a message must have the fixed size of its type, a string must end
 * within its field, and the value of an enumeration must be below its COUNT. The record of an image contains no names,
 * identifiers, dates, times or institutions. The identities of the patient, the study and the frame of reference are
 * SHA-256 digests, salted with random bytes from the request, so they are comparable only within one request.
 *
 * This header is included from C and C++.
 */
#ifndef OST_IO_DICOM_PROTOCOL_H
#define OST_IO_DICOM_PROTOCOL_H

#include <stdint.h>

enum { OST_DICOM_MAGIC = 0x4d43444f, OST_DICOM_VERSION = 1 };

typedef enum ost_dicom_action { OST_DICOM_SCAN, OST_DICOM_READ } ost_dicom_action;

enum { OST_DICOM_SALT = 16, OST_DICOM_IDENTITY = 32, OST_DICOM_PATH_MAX = 4096 };
/*
 * Size of a text field in bytes, including its NUL. The standard limits a decimal (DS) to 16 bytes, but real files
 * contain longer ones.
 */
enum { OST_DICOM_DECIMAL = 40, OST_DICOM_TEXT = 65 };

typedef struct ost_dicom_request {
    uint32_t magic, version;
    uint32_t action; /* ost_dicom_action */
    uint32_t paths;  /* number of paths that follow the request */
    uint32_t images; /* number of ost_dicom_image structs that follow the paths; 0 for a scan */
    uint8_t salt[OST_DICOM_SALT];
} ost_dicom_request;

/* An image to read. Its pixels must have 2 * columns * rows bytes. */
typedef struct ost_dicom_image {
    uint32_t file; /* index of the path in the request */
    uint32_t frame;
    uint32_t columns, rows;
} ost_dicom_image;

typedef enum ost_dicom_type {
    OST_DICOM_FRAME,  /* payload: an ost_dicom_record; index: index of the path */
    /* payload: an ost_dicom_result as a uint32_t; index: index of the path or image */
    OST_DICOM_FILE,
    /* payload: the stored pixel cells, rows * columns uint16_t; index: index of the image */
    OST_DICOM_PIXELS,
    OST_DICOM_END,    /* no payload */
    OST_DICOM_TYPE_COUNT
} ost_dicom_type;

typedef struct ost_dicom_message {
    uint32_t type; /* ost_dicom_type */
    uint32_t index;
    uint32_t size; /* size of the following payload in bytes */
} ost_dicom_message;

typedef enum ost_dicom_result {
    OST_DICOM_RESULT_OK,
    /* the file begins neither with the prefix DICM nor with a data set whose first group is 0008 */
    OST_DICOM_RESULT_NOT_DICOM,
    OST_DICOM_RESULT_NO_IMAGE,    /* a DICOM file without an image, such as a report, a structure set or a DICOMDIR */
    OST_DICOM_RESULT_UNREADABLE,  /* the file cannot be opened or read */
    OST_DICOM_RESULT_DAMAGED,     /* the file is truncated or not well-formed */
    OST_DICOM_RESULT_UNSUPPORTED, /* osteon-dicom has no decoder for the transfer syntax */
    OST_DICOM_RESULT_NO_JPEG2000, /* the transfer syntax is JPEG 2000, but osteon-dicom was built without OpenJPEG */
    /* the pixels cannot be decoded, or the dimensions of the decoded image differ from the request */
    OST_DICOM_RESULT_UNDECODABLE,
    OST_DICOM_RESULT_MEMORY,      /* decoding needs more memory than osteon-dicom may use */
    OST_DICOM_RESULT_TOO_LARGE,   /* the file has more bytes, frames or pixels than the limits below */
    OST_DICOM_RESULT_COUNT
} ost_dicom_result;

enum {
    OST_DICOM_IMAGE_LOCALIZER = 1 << 0, /* ImageType has the value LOCALIZER */
    /* the image has LossyImageCompression, or a transfer syntax that is lossy by definition */
    OST_DICOM_IMAGE_LOSSY = 1 << 1,
    OST_DICOM_IMAGE_SIGNED = 1 << 2,
    OST_DICOM_IMAGE_COLOUR = 1 << 3,    /* the image has more than one sample per pixel, or a colour palette */
    OST_DICOM_IMAGE_FLOAT = 1 << 4,     /* the image has FloatPixelData or DoubleFloatPixelData */
    OST_DICOM_IMAGE_LUT = 1 << 5,       /* the image has a ModalityLUTSequence, that is, its rescaling is not linear */
    OST_DICOM_IMAGE_PADDED = 1 << 6,    /* padding_first and padding_last are valid */
    OST_DICOM_IMAGE_NUMBERED = 1 << 7,  /* series_number is valid */
    OST_DICOM_IMAGE_ENCRYPTED = 1 << 8, /* the image has an EncryptedAttributesSequence */
    OST_DICOM_IMAGE_ALL = (1 << 9) - 1
};

/*
 * The attributes of an image. Decimals are stored as text, exactly as in the file; the text is "" if the attribute is
 * absent or empty.
 */
typedef struct ost_dicom_record {
    uint32_t frame;      /* number of the frame in the file, from 0 */
    uint32_t result;     /* ost_dicom_result: OK, or the reason why the pixels of this image cannot be read */
    uint32_t flags;      /* OST_DICOM_IMAGE_... */
    uint32_t columns, rows;
    uint32_t bits_allocated, bits_stored, high_bit;
    int32_t series_number;
    int32_t padding_first, padding_last; /* PixelPaddingValue and PixelPaddingRangeLimit; the smaller value is first */
    /* identity of the patient; all bytes are 0 if the file does not identify the patient */
    uint8_t patient[OST_DICOM_IDENTITY];
    uint8_t study[OST_DICOM_IDENTITY];
    uint8_t reference[OST_DICOM_IDENTITY]; /* identity of the frame of reference */
    char position[3][OST_DICOM_DECIMAL];   /* ImagePositionPatient */
    char orientation[6][OST_DICOM_DECIMAL]; /* ImageOrientationPatient */
    /* PixelSpacing: the distance between rows, then the distance between columns */
    char spacing[2][OST_DICOM_DECIMAL];
    char thickness[OST_DICOM_DECIMAL];
    char slope[OST_DICOM_DECIMAL], intercept[OST_DICOM_DECIMAL];
    char syntax[OST_DICOM_TEXT];      /* UID of the transfer syntax */
    char series_uid[OST_DICOM_TEXT];
    char description[OST_DICOM_TEXT]; /* SeriesDescription, truncated */
    char kernel[OST_DICOM_TEXT];      /* ConvolutionKernel, truncated */
    char modality[OST_DICOM_TEXT];
} ost_dicom_record;

/* Limits, as documented in docs/reference/files.md. The library and osteon-dicom both check them. */
enum {
    OST_DICOM_FILES_MAX = 1 << 16,  /* maximum number of files in a folder */
    OST_DICOM_IMAGES_MAX = 1 << 16, /* maximum number of images in all of these files */
    OST_DICOM_DEPTH_MAX = 16,       /* maximum depth of nested folders */
    OST_DICOM_SIDE_MAX = 16384      /* maximum number of rows and of columns; equal to OST_DIM_MAX */
};
#define OST_DICOM_FILE_BYTES_MAX (INT64_C(1) << 32)
#define OST_DICOM_MEMORY_MAX (INT64_C(2) << 30) /* limit on the address space of osteon-dicom, in bytes */

#endif
