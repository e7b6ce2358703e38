// SPDX-License-Identifier: Apache-2.0
//
// Reads the pixels of an image.
//
//   uncompressed, deflated   a part of the value, in the machine's byte order
//   JPEG, JPEG-LS, RLE       decoded by DCMTK
//   JPEG 2000                the frame's fragments, decoded by jpeg2000.cpp
//
// The result has one cell of 16 bits per pixel; the library extracts the stored bits.
#include "io/dicom/child/child.h"

#include <cstring>

#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>

static ost_dicom_result open_at(open_file &from, const char *path)
{
    if (from.path == path)
        return OST_DICOM_RESULT_OK;
    from.path = nullptr;
    from.file.clear();
    from.cache.clear();
    from.next_frame = from.next_fragment = 0;
    const ost_dicom_result loaded = load_file(path, from.file);
    if (loaded == OST_DICOM_RESULT_OK)
        from.path = path;
    return loaded;
}

// Converts `count` one-byte pixels at the start of `cells` to cells, in place.
static void widen(uint16_t *cells, size_t count)
{
    const uint8_t *bytes = reinterpret_cast<const uint8_t *>(cells);
    for (size_t i = count; i-- > 0;)
        cells[i] = bytes[i];
}

// Finds the fragments [*begin, *end) of a frame. Item 0 of the sequence is the table of frame offsets.
static bool find_fragments(DcmPixelSequence *sequence, uint32_t frame, uint32_t frames, unsigned long *begin,
                           unsigned long *end)
{
    const unsigned long count = sequence->card();
    DcmPixelItem *item = nullptr;
    if (count < 2 || frame >= frames)
        return false;
    *begin = 1;
    *end = count;
    if (frames == 1)
        return true;
    if (count - 1 == frames) {
        *begin = frame + 1UL;
        *end = frame + 2UL;
        return true;
    }
    Uint8 *table = nullptr;
    if (sequence->getItem(item, 0).bad() || item->getLength() < frames * 4UL || item->getUint8Array(table).bad() ||
        !table)
        return false;
    uint32_t first, last = UINT32_MAX, offset = 0;
    std::memcpy(&first, table + 4UL * frame, 4);
    if (frame + 1 < frames)
        std::memcpy(&last, table + 4UL * (frame + 1), 4);
    *begin = 0;
    for (unsigned long i = 1; i < count; i++) {
        if (offset == first)
            *begin = i;
        if (offset == last)
            *end = i;
        if (sequence->getItem(item, i).bad())
            return false;
        offset += item->getLength() + 8;
    }
    return *begin > 0 && *end > *begin;
}

// Copies the fragments of a frame into one stream.
static ost_dicom_result read_stream(DcmDataset *data_set, DcmPixelData *pixels, uint32_t frame,
                                    std::vector<uint8_t> &stream)
{
    Sint32 frames = 1;
    DcmPixelSequence *sequence = nullptr;
    unsigned long begin, end;
    if (data_set->tagExistsWithValue(DCM_NumberOfFrames))
        (void)data_set->findAndGetSint32(DCM_NumberOfFrames, frames);
    if (pixels->getEncapsulatedRepresentation(data_set->getOriginalXfer(), nullptr, sequence).bad() || !sequence)
        return OST_DICOM_RESULT_DAMAGED;
    if (!find_fragments(sequence, frame, static_cast<uint32_t>(frames), &begin, &end))
        return OST_DICOM_RESULT_UNDECODABLE;
    for (unsigned long i = begin; i < end; i++) {
        DcmPixelItem *item = nullptr;
        Uint8 *bytes = nullptr;
        if (sequence->getItem(item, i).bad() || item->getUint8Array(bytes).bad() || !bytes)
            return OST_DICOM_RESULT_DAMAGED;
        stream.insert(stream.end(), bytes, bytes + item->getLength());
        item->compact();
    }
    return OST_DICOM_RESULT_OK;
}

static ost_dicom_result read_compressed(open_file &from, DcmPixelData *pixels, const ost_dicom_image &image,
                                        void *cells, size_t bytes, uint32_t pixel_bytes)
{
    DcmDataset *data_set = from.file.getDataset();
    const E_TransferSyntax syntax = data_set->getOriginalXfer();
    std::vector<uint8_t> stream;
    ost_dicom_result result = read_stream(data_set, pixels, image.frame, stream);
    if (result != OST_DICOM_RESULT_OK)
        return result;
#ifdef HAVE_OPENJPEG
    if (syntax == EXS_JPEG2000LosslessOnly || syntax == EXS_JPEG2000)
        return decode_jpeg2000(stream, image.columns, image.rows, static_cast<uint16_t *>(cells));
#endif
    if (syntax == EXS_RLELossless ? !is_rle_of_size(stream, image.columns, image.rows, pixel_bytes)
                                  : !is_jpeg_of_size(stream, image.columns, image.rows, pixel_bytes))
        return OST_DICOM_RESULT_UNDECODABLE;
    OFString colour;
    Uint32 fragment = image.frame == from.next_frame ? from.next_fragment : 0;
    const OFCondition decoded = pixels->getUncompressedFrame(data_set, image.frame, fragment, cells,
                                                             static_cast<Uint32>(bytes), colour, &from.cache);
    from.next_frame = image.frame + 1;
    from.next_fragment = fragment;
    if (decoded == EC_MemoryExhausted)
        return OST_DICOM_RESULT_MEMORY;
    return decoded.good() ? OST_DICOM_RESULT_OK : OST_DICOM_RESULT_UNDECODABLE;
}

ost_dicom_result read_image(open_file &from, const char *path, const ost_dicom_image &image,
                            std::vector<uint16_t> &cells)
{
    const size_t count = size_t{image.columns} * image.rows;
    char uid[OST_DICOM_TEXT];
    Uint16 allocated = 0, columns = 0, rows = 0, samples = 1;
    DcmElement *element = nullptr;
    ost_dicom_result result = open_at(from, path);
    if (result == OST_DICOM_RESULT_OK)
        result = check_syntax(from.file, uid);
    if (result != OST_DICOM_RESULT_OK)
        return result;
    // These attributes are checked again, because the file may have changed since it was scanned.
    DcmDataset *data_set = from.file.getDataset();
    (void)data_set->findAndGetUint16(DCM_SamplesPerPixel, samples);
    if (data_set->findAndGetUint16(DCM_Columns, columns).bad() || columns != image.columns ||
        data_set->findAndGetUint16(DCM_Rows, rows).bad() || rows != image.rows || samples != 1 ||
        data_set->findAndGetUint16(DCM_BitsAllocated, allocated).bad() || (allocated != 8 && allocated != 16) ||
        data_set->findAndGetElement(DCM_PixelData, element).bad() || !element)
        return OST_DICOM_RESULT_DAMAGED;
    DcmPixelData *pixels = OFstatic_cast(DcmPixelData *, element);
    // One cell more, because a decoder may round the number of bytes up to an even number.
    cells.resize(count + 1);
    const size_t bytes = count * (allocated / 8), padded = bytes + (bytes & 1);
    if (is_encapsulated(uid)) {
        result = read_compressed(from, pixels, image, cells.data(), padded, allocated / 8U);
    } else {
        const uint64_t offset = uint64_t{bytes} * image.frame;
        if (offset + bytes > pixels->getLengthField())
            return OST_DICOM_RESULT_DAMAGED;
        if (pixels->getPartialValue(cells.data(), static_cast<Uint32>(offset), static_cast<Uint32>(bytes), &from.cache)
                .bad())
            result = OST_DICOM_RESULT_DAMAGED;
    }
    const E_TransferSyntax syntax = DcmXfer(uid).getXfer();
    const bool is_jpeg2000 = syntax == EXS_JPEG2000LosslessOnly || syntax == EXS_JPEG2000;
    if (result == OST_DICOM_RESULT_OK && allocated == 8 && !is_jpeg2000)
        widen(cells.data(), count);
    cells.resize(count);
    return result;
}
