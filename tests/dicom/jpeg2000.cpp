// SPDX-License-Identifier: Apache-2.0
#include "jpeg2000.h"

#include <openjpeg.h>

#include <algorithm>
#include <cstring>

namespace {

// An output stream of OpenJPEG that writes to memory.
struct sink {
    std::vector<uint8_t> bytes;
    size_t at = 0;
};

OPJ_SIZE_T put(void *buffer, OPJ_SIZE_T size, void *user)
{
    sink *out = static_cast<sink *>(user);
    out->bytes.resize(std::max(out->bytes.size(), out->at + size));
    memcpy(out->bytes.data() + out->at, buffer, size);
    out->at += size;
    return size;
}

OPJ_OFF_T skip(OPJ_OFF_T size, void *user)
{
    static_cast<sink *>(user)->at += static_cast<size_t>(size);
    return size;
}

OPJ_BOOL seek(OPJ_OFF_T to, void *user)
{
    static_cast<sink *>(user)->at = static_cast<size_t>(to);
    return OPJ_TRUE;
}

opj_image_t *make_image(const std::vector<uint8_t> &pixels, int columns, int rows, int allocated, int bits,
                        bool is_signed)
{
    opj_image_cmptparm_t component = {};
    component.dx = component.dy = 1;
    component.w = static_cast<OPJ_UINT32>(columns);
    component.h = static_cast<OPJ_UINT32>(rows);
    component.prec = static_cast<OPJ_UINT32>(bits);
    component.sgnd = is_signed;
    opj_image_t *image = opj_image_create(1, &component, OPJ_CLRSPC_GRAY);
    if (!image)
        return nullptr;
    image->x1 = component.w;
    image->y1 = component.h;
    for (size_t v = 0; v < size_t(columns) * rows; v++) {
        const uint32_t word = allocated == 8 ? pixels[v] : pixels[2 * v] | uint32_t(pixels[2 * v + 1]) << 8;
        int32_t value = static_cast<int32_t>(word & ((1u << bits) - 1));
        if (is_signed && value >> (bits - 1))
            value -= 1 << bits;
        image->comps[0].data[v] = value;
    }
    return image;
}

} // namespace

std::vector<uint8_t> encode_jpeg2000(const std::vector<uint8_t> &pixels, int columns, int rows, int allocated, int bits,
                                     bool is_signed, bool lossless)
{
    sink out;
    opj_image_t *image = make_image(pixels, columns, rows, allocated, bits, is_signed);
    opj_codec_t *codec = opj_create_compress(OPJ_CODEC_J2K);
    opj_stream_t *stream = opj_stream_create(4096, OPJ_FALSE);
    opj_cparameters_t how;
    opj_set_default_encoder_parameters(&how);
    how.irreversible = !lossless;
    how.tcp_numlayers = 1;
    how.tcp_distoratio[0] = lossless ? 0 : 80; // peak signal-to-noise ratio in dB
    how.cp_disto_alloc = lossless;
    how.cp_fixed_quality = !lossless;
    // An image needs at least 2^(resolutions - 1) pixels along each axis.
    how.numresolution = 1;
    while (how.numresolution < 6 && (1 << how.numresolution) <= std::min(columns, rows))
        how.numresolution++;
    bool good = image && codec && stream && opj_setup_encoder(codec, &how, image);
    if (good) {
        opj_stream_set_write_function(stream, put);
        opj_stream_set_skip_function(stream, skip);
        opj_stream_set_seek_function(stream, seek);
        opj_stream_set_user_data(stream, &out, nullptr);
        good = opj_start_compress(codec, image, stream) && opj_encode(codec, stream) && opj_end_compress(codec, stream);
    }
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    opj_image_destroy(image);
    return good ? out.bytes : std::vector<uint8_t>();
}
