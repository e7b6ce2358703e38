// SPDX-License-Identifier: Apache-2.0
//
// Decodes JPEG 2000 with OpenJPEG. Before decoding, the size in the code stream's header is compared with the size of
// the image, so that a stream cannot make the decoder allocate more memory than its image needs.
#include "io/dicom/child/child.h"

#include <algorithm>
#include <cstring>

#include <openjpeg.h>

struct source {
    const uint8_t *bytes;
    size_t size, at;
};

static OPJ_SIZE_T read_source(void *to, OPJ_SIZE_T wanted, void *user)
{
    source *s = static_cast<source *>(user);
    if (s->at >= s->size)
        return static_cast<OPJ_SIZE_T>(-1);
    const size_t n = std::min<size_t>(wanted, s->size - s->at);
    std::memcpy(to, s->bytes + s->at, n);
    s->at += n;
    return n;
}

static OPJ_OFF_T skip_source(OPJ_OFF_T count, void *user)
{
    source *s = static_cast<source *>(user);
    if (count < 0 || static_cast<uint64_t>(count) > s->size - s->at)
        return -1;
    s->at += static_cast<size_t>(count);
    return count;
}

static OPJ_BOOL seek_source(OPJ_OFF_T to, void *user)
{
    source *s = static_cast<source *>(user);
    if (to < 0 || static_cast<uint64_t>(to) > s->size)
        return OPJ_FALSE;
    s->at = static_cast<size_t>(to);
    return OPJ_TRUE;
}

static bool is_expected(const opj_image_t *image, uint32_t columns, uint32_t rows)
{
    return image && image->numcomps == 1 && image->comps[0].w == columns && image->comps[0].h == rows &&
           image->comps[0].prec <= 16;
}

ost_dicom_result decode_jpeg2000(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows, uint16_t *cells)
{
    static const uint8_t box[] = {0, 0, 0, 12, 'j', 'P', ' ', ' '};
    const bool is_jp2 = stream.size() >= sizeof box && std::memcmp(stream.data(), box, sizeof box) == 0;
    source from = {stream.data(), stream.size(), 0};
    opj_image_t *image = nullptr;
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    opj_codec_t *codec = opj_create_decompress(is_jp2 ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K);
    opj_stream_t *input = opj_stream_create(std::max<size_t>(std::min<size_t>(stream.size(), 1 << 20), 1), OPJ_TRUE);
    ost_dicom_result result = codec && input ? OST_DICOM_RESULT_UNDECODABLE : OST_DICOM_RESULT_MEMORY;
    if (codec && input) {
        opj_stream_set_user_data(input, &from, nullptr);
        opj_stream_set_user_data_length(input, stream.size());
        opj_stream_set_read_function(input, read_source);
        opj_stream_set_skip_function(input, skip_source);
        opj_stream_set_seek_function(input, seek_source);
        if (opj_setup_decoder(codec, &parameters) && opj_read_header(input, codec, &image) &&
            is_expected(image, columns, rows) && opj_decode(codec, input, image) &&
            opj_end_decompress(codec, input) && is_expected(image, columns, rows) && image->comps[0].data)
            result = OST_DICOM_RESULT_OK;
    }
    if (result == OST_DICOM_RESULT_OK)
        for (size_t i = 0; i < size_t{columns} * rows; i++)
            cells[i] = static_cast<uint16_t>(image->comps[0].data[i]);
    opj_image_destroy(image);
    opj_stream_destroy(input);
    opj_destroy_codec(codec);
    return result;
}
