// SPDX-License-Identifier: Apache-2.0
//
// Sends the attributes of the images of a file.
//
//   classic image          attributes of the data set
//   enhanced multi-frame   attributes of the frame's item of PerFrameFunctionalGroupsSequence, else of
//                          SharedFunctionalGroupsSequence, else of the data set
#include "io/dicom/child/child.h"

#include <cstdio>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openssl/evp.h>

// Longer values are not loaded. The attributes that are read have at most 6 decimals of 16 bytes.
enum { VALUE_BYTES_MAX = 1024 };

static bool has_prefix(const unsigned char *head, size_t size)
{
    return size >= 132 && std::memcmp(head + 128, "DICM", 4) == 0;
}

// Returns true if the file begins with an element of group 0008, like a data set without the prefix DICM.
static bool is_data_set(const unsigned char *head, size_t size)
{
    return size >= 132 && ((head[0] == 8 && head[1] == 0) || (head[0] == 0 && head[1] == 8)) && head[3] == 0;
}

ost_dicom_result load_file(const char *path, DcmFileFormat &file)
{
    unsigned char head[132];
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK); // core/file.c is not part of this program
    if (fd < 0)
        return OST_DICOM_RESULT_UNREADABLE;
    const bool regular = fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    const ssize_t n = regular ? pread(fd, head, sizeof head, 0) : -1;
    close(fd);
    if (n < 0)
        return OST_DICOM_RESULT_UNREADABLE;
    const bool prefix = has_prefix(head, static_cast<size_t>(n));
    if (!prefix && !is_data_set(head, static_cast<size_t>(n)))
        return OST_DICOM_RESULT_NOT_DICOM;
    if (info.st_size > OST_DICOM_FILE_BYTES_MAX)
        return OST_DICOM_RESULT_TOO_LARGE;
    const OFCondition loaded =
        file.loadFile(OFFilename(path), EXS_Unknown, EGL_noChange, VALUE_BYTES_MAX, ERM_autoDetect);
    if (loaded == EC_MemoryExhausted)
        return OST_DICOM_RESULT_MEMORY;
    if (loaded.good())
        return OST_DICOM_RESULT_OK;
    // Without the prefix, a file may resemble DICOM only by coincidence, so an image's attribute is required.
    return prefix || file.getDataset()->tagExists(DCM_SOPClassUID) ? OST_DICOM_RESULT_DAMAGED
                                                                  : OST_DICOM_RESULT_NOT_DICOM;
}

ost_dicom_result check_syntax(const DcmFileFormat &file, char uid[OST_DICOM_TEXT])
{
    DcmFileFormat &source = const_cast<DcmFileFormat &>(file); // the accessors of DCMTK are not const
    E_TransferSyntax syntax = source.getDataset()->getOriginalXfer();
    OFString stated;
    if (source.getMetaInfo()->findAndGetOFString(DCM_TransferSyntaxUID, stated).good() && !stated.empty()) {
        syntax = DcmXfer(stated.c_str()).getXfer();
        std::snprintf(uid, OST_DICOM_TEXT, "%s", stated.c_str());
    } else {
        std::snprintf(uid, OST_DICOM_TEXT, "%s", DcmXfer(syntax).getXferID());
    }
    switch (syntax) {
    case EXS_LittleEndianImplicit:
    case EXS_LittleEndianExplicit:
    case EXS_BigEndianExplicit:
    case EXS_DeflatedLittleEndianExplicit:
    case EXS_JPEGProcess1:
    case EXS_JPEGProcess2_4:
    case EXS_JPEGProcess14:
    case EXS_JPEGProcess14SV1:
    case EXS_JPEGLSLossless:
    case EXS_JPEGLSLossy:
    case EXS_RLELossless: return OST_DICOM_RESULT_OK;
    case EXS_JPEG2000LosslessOnly:
    case EXS_JPEG2000:
#ifdef HAVE_OPENJPEG
        return OST_DICOM_RESULT_OK;
#else
        return OST_DICOM_RESULT_NO_JPEG2000;
#endif
    default: return OST_DICOM_RESULT_UNSUPPORTED;
    }
}

bool is_encapsulated(const char *uid)
{
    const E_TransferSyntax syntax = DcmXfer(uid).getXfer();
    return syntax != EXS_LittleEndianImplicit && syntax != EXS_LittleEndianExplicit &&
           syntax != EXS_BigEndianExplicit && syntax != EXS_DeflatedLittleEndianExplicit;
}

static bool is_lossy(const char *uid)
{
    const E_TransferSyntax syntax = DcmXfer(uid).getXfer();
    return syntax == EXS_JPEGProcess1 || syntax == EXS_JPEGProcess2_4 || syntax == EXS_JPEGLSLossy;
}

// ------------------------------------------------------------------------------------ values

static OFString text_of(DcmItem *item, const DcmTagKey &tag, unsigned long at = 0)
{
    OFString value;
    if (!item || item->findAndGetOFString(tag, value, at).bad())
        value.clear();
    return value;
}

static uint32_t number_of(DcmItem *item, const DcmTagKey &tag, uint32_t absent)
{
    Uint16 value;
    return item->findAndGetUint16(tag, value).good() ? value : absent;
}

// Copies a decimal. Any other string, which may be a misplaced name, is replaced by a placeholder that the library
// refuses.
static void put_decimal(DcmItem *item, const DcmTagKey &tag, unsigned long at, char out[OST_DICOM_DECIMAL])
{
    const OFString value = text_of(item, tag, at);
    size_t begin = 0, end = value.length();
    while (begin < end && value[begin] == ' ')
        begin++;
    while (end > begin && (value[end - 1] == ' ' || value[end - 1] == '\0'))
        end--;
    const OFString decimal = value.substr(begin, end - begin);
    if (decimal.find_first_not_of("0123456789+-.eE") != OFString_npos)
        std::snprintf(out, OST_DICOM_DECIMAL, "not a decimal");
    else if (decimal.length() >= OST_DICOM_DECIMAL)
        std::snprintf(out, OST_DICOM_DECIMAL, "%.16s...", decimal.c_str());
    else
        std::snprintf(out, OST_DICOM_DECIMAL, "%s", decimal.c_str());
}

// Copies a string as UTF-8. ISO 8859-1 is converted; other bytes that are not UTF-8 are replaced by the library.
static void put_text(DcmItem *item, const DcmTagKey &tag, bool latin, char out[OST_DICOM_TEXT])
{
    const OFString value = text_of(item, tag);
    size_t n = 0, end = value.length();
    while (end && (value[end - 1] == ' ' || value[end - 1] == '\0'))
        end--;
    for (size_t i = 0; i < end && n + 2 < OST_DICOM_TEXT; i++) {
        const unsigned char c = static_cast<unsigned char>(value[i]);
        if (latin && c >= 0xa0) {
            out[n++] = static_cast<char>(0xc0 | c >> 6);
            out[n++] = static_cast<char>(0x80 | (c & 0x3f));
        } else {
            out[n++] = c ? static_cast<char>(c) : '?';
        }
    }
    out[n] = '\0';
}

// Computes the digest of an identity. If the file does not state the identity, the digest is all zeros.
static void put_identity(const uint8_t salt[OST_DICOM_SALT], const OFString &identity,
                         uint8_t out[OST_DICOM_IDENTITY])
{
    std::memset(out, 0, OST_DICOM_IDENTITY);
    if (identity.empty())
        return;
    std::string salted(reinterpret_cast<const char *>(salt), OST_DICOM_SALT);
    salted.append(identity.c_str(), identity.length());
    if (EVP_Digest(salted.data(), salted.size(), out, nullptr, EVP_sha256(), nullptr) != 1)
        throw std::bad_alloc();
}

static bool has_value(DcmItem *item, const DcmTagKey &tag, const char *wanted)
{
    OFString value;
    for (unsigned long i = 0; i < 16 && item->findAndGetOFString(tag, value, i).good(); i++)
        if (value == wanted)
            return true;
    return false;
}

// ------------------------------------------------------------------------------------ an image

// The items in which an attribute of a frame may be, in the order of the search.
struct frame_items {
    DcmItem *own, *shared, *data_set;
};

// Returns the item that contains the attribute `tag` of a frame: an item of `sequence` in a functional group, or the
// data set.
static DcmItem *holder_of(const frame_items &items, const DcmTagKey &sequence, const DcmTagKey &tag)
{
    DcmItem *const groups[2] = {items.own, items.shared};
    for (DcmItem *group : groups) {
        DcmItem *item = nullptr;
        if (group && group->findAndGetSequenceItem(sequence, item).good() && item && item->tagExistsWithValue(tag))
            return item;
    }
    return items.data_set;
}

static void put_geometry(const frame_items &items, ost_dicom_record &record)
{
    DcmItem *item = holder_of(items, DCM_PlanePositionSequence, DCM_ImagePositionPatient);
    for (unsigned long i = 0; i < 3; i++)
        put_decimal(item, DCM_ImagePositionPatient, i, record.position[i]);
    item = holder_of(items, DCM_PlaneOrientationSequence, DCM_ImageOrientationPatient);
    for (unsigned long i = 0; i < 6; i++)
        put_decimal(item, DCM_ImageOrientationPatient, i, record.orientation[i]);
    item = holder_of(items, DCM_PixelMeasuresSequence, DCM_PixelSpacing);
    for (unsigned long i = 0; i < 2; i++)
        put_decimal(item, DCM_PixelSpacing, i, record.spacing[i]);
    item = holder_of(items, DCM_PixelMeasuresSequence, DCM_SliceThickness);
    put_decimal(item, DCM_SliceThickness, 0, record.thickness);
    item = holder_of(items, DCM_PixelValueTransformationSequence, DCM_RescaleSlope);
    put_decimal(item, DCM_RescaleSlope, 0, record.slope);
    item = holder_of(items, DCM_PixelValueTransformationSequence, DCM_RescaleIntercept);
    put_decimal(item, DCM_RescaleIntercept, 0, record.intercept);
    item = holder_of(items, DCM_CTImageFrameTypeSequence, DCM_FrameType);
    if (item != items.data_set && has_value(item, DCM_FrameType, "LOCALIZER"))
        record.flags |= OST_DICOM_IMAGE_LOCALIZER;
}

// PixelPaddingValue has the VR US or SS; its 16 bits are a pixel cell of the image.
static bool cell_of(DcmItem *item, const DcmTagKey &tag, bool is_signed, int32_t &out)
{
    Uint16 plain;
    Sint16 negative;
    if (item->findAndGetUint16(tag, plain).bad()) {
        if (item->findAndGetSint16(tag, negative).bad())
            return false;
        plain = static_cast<Uint16>(negative);
    }
    out = is_signed ? static_cast<Sint16>(plain) : static_cast<int32_t>(plain);
    return true;
}

static void put_pixel_form(DcmItem *data_set, ost_dicom_record &record)
{
    record.columns = number_of(data_set, DCM_Columns, 0);
    record.rows = number_of(data_set, DCM_Rows, 0);
    record.bits_allocated = number_of(data_set, DCM_BitsAllocated, 0);
    record.bits_stored = number_of(data_set, DCM_BitsStored, record.bits_allocated);
    record.high_bit = number_of(data_set, DCM_HighBit, record.bits_stored - 1);
    const OFString photometric = text_of(data_set, DCM_PhotometricInterpretation);
    if (number_of(data_set, DCM_SamplesPerPixel, 1) != 1 || photometric == "PALETTE COLOR")
        record.flags |= OST_DICOM_IMAGE_COLOUR;
    const bool is_signed = number_of(data_set, DCM_PixelRepresentation, 0) == 1;
    if (is_signed)
        record.flags |= OST_DICOM_IMAGE_SIGNED;
    if (data_set->tagExists(DCM_ModalityLUTSequence))
        record.flags |= OST_DICOM_IMAGE_LUT;
    if (cell_of(data_set, DCM_PixelPaddingValue, is_signed, record.padding_first)) {
        record.flags |= OST_DICOM_IMAGE_PADDED;
        record.padding_last = record.padding_first;
        int32_t limit;
        if (cell_of(data_set, DCM_PixelPaddingRangeLimit, is_signed, limit)) {
            record.padding_first = limit < record.padding_last ? limit : record.padding_last;
            record.padding_last = limit > record.padding_last ? limit : record.padding_last;
        }
    }
}

static void put_series(DcmItem *data_set, const uint8_t salt[OST_DICOM_SALT], ost_dicom_record &record)
{
    const bool latin = text_of(data_set, DCM_SpecificCharacterSet) == "ISO_IR 100";
    put_text(data_set, DCM_SeriesInstanceUID, false, record.series_uid);
    put_text(data_set, DCM_SeriesDescription, latin, record.description);
    put_text(data_set, DCM_ConvolutionKernel, latin, record.kernel);
    put_text(data_set, DCM_Modality, false, record.modality);
    Sint32 number;
    if (data_set->findAndGetSint32(DCM_SeriesNumber, number).good()) {
        record.series_number = number;
        record.flags |= OST_DICOM_IMAGE_NUMBERED;
    }
    if (has_value(data_set, DCM_ImageType, "LOCALIZER"))
        record.flags |= OST_DICOM_IMAGE_LOCALIZER;
    if (text_of(data_set, DCM_LossyImageCompression) == "01" || is_lossy(record.syntax))
        record.flags |= OST_DICOM_IMAGE_LOSSY;
    if (data_set->tagExists(DCM_EncryptedAttributesSequence))
        record.flags |= OST_DICOM_IMAGE_ENCRYPTED;
    const OFString id = text_of(data_set, DCM_PatientID);
    put_identity(salt, id.empty() ? text_of(data_set, DCM_PatientName) : id, record.patient);
    put_identity(salt, text_of(data_set, DCM_StudyInstanceUID), record.study);
    put_identity(salt, text_of(data_set, DCM_FrameOfReferenceUID), record.reference);
}

// Returns DAMAGED if there are no pixels, or if there are fewer uncompressed pixels than the frames need. Pixels that
// have neither 8 nor 16 bits are later refused by the library.
static ost_dicom_result check_length(DcmItem *data_set, const ost_dicom_record &record, uint32_t frames)
{
    DcmElement *pixels = nullptr;
    if (data_set->findAndGetElement(DCM_PixelData, pixels).bad() || !pixels)
        return OST_DICOM_RESULT_DAMAGED;
    if (is_encapsulated(record.syntax) || (record.bits_allocated != 8 && record.bits_allocated != 16))
        return OST_DICOM_RESULT_OK;
    const uint64_t needed = uint64_t{record.columns} * record.rows * (record.bits_allocated / 8) * frames;
    return pixels->getLengthField() >= needed ? OST_DICOM_RESULT_OK : OST_DICOM_RESULT_DAMAGED;
}

ost_dicom_result scan_file(const char *path, uint32_t index, const uint8_t salt[OST_DICOM_SALT])
{
    DcmFileFormat file;
    const ost_dicom_result loaded = load_file(path, file);
    if (loaded != OST_DICOM_RESULT_OK && loaded != OST_DICOM_RESULT_DAMAGED)
        return loaded;
    DcmDataset *data_set = file.getDataset();
    ost_dicom_record record;
    std::memset(&record, 0, sizeof record);
    if (data_set->tagExists(DCM_FloatPixelData) || data_set->tagExists(DCM_DoubleFloatPixelData))
        record.flags |= OST_DICOM_IMAGE_FLOAT;
    else if (loaded == OST_DICOM_RESULT_OK && !data_set->tagExists(DCM_PixelData) && !data_set->tagExists(DCM_Rows))
        return OST_DICOM_RESULT_NO_IMAGE;
    Sint32 frames = 1;
    if (data_set->tagExistsWithValue(DCM_NumberOfFrames) &&
        (data_set->findAndGetSint32(DCM_NumberOfFrames, frames).bad() || frames < 1))
        return OST_DICOM_RESULT_DAMAGED;
    if (frames > OST_DICOM_IMAGES_MAX)
        return OST_DICOM_RESULT_TOO_LARGE;
    record.result = check_syntax(file, record.syntax);
    put_series(data_set, salt, record);
    put_pixel_form(data_set, record);
    if (loaded != OST_DICOM_RESULT_OK) {
        // An image of a damaged file still belongs to its series, because a missing slice must be reported.
        record.result = loaded;
        if (!data_set->tagExists(DCM_Rows))
            return loaded;
        frames = 1;
    } else if (record.result == OST_DICOM_RESULT_OK && !(record.flags & OST_DICOM_IMAGE_FLOAT)) {
        record.result = check_length(data_set, record, static_cast<uint32_t>(frames));
    }
    frame_items items = {nullptr, nullptr, data_set};
    DcmSequenceOfItems *per_frame = nullptr;
    if (data_set->findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, per_frame).bad())
        per_frame = nullptr;
    if (data_set->findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, items.shared).bad())
        items.shared = nullptr;
    const ost_dicom_record common = record;
    for (Sint32 f = 0; f < frames; f++) {
        items.own = per_frame && static_cast<unsigned long>(f) < per_frame->card()
                        ? per_frame->getItem(static_cast<unsigned long>(f))
                        : nullptr;
        record = common;
        record.frame = static_cast<uint32_t>(f);
        put_geometry(items, record);
        send_message(OST_DICOM_FRAME, index, &record, sizeof record);
    }
    return OST_DICOM_RESULT_OK;
}
